//! How far light has to be moved to turn one highlight into another: the exact transport distance W1.
//!
//! Between two images it is a transportation problem, solved here by the primal network simplex on the complete
//! bipartite graph. The basis is a strongly feasible tree (Cunningham 1976, "A network simplex method"): every arc
//! without flow points to the root, and the rule for the leaving arc keeps it so; no sequence of pivots can repeat.
//! Masses are whole numbers, so flows are exact and "without flow" means exactly zero.

use glam::DVec3;
use rayon::prelude::*;

use super::tally::MeasureError;
use crate::progress::{Cancelled, Progress};
use crate::projection::{Projection, View};
use crate::raster::Raster;
use crate::slope::angle_between;

/// The mass that is moved, in the whole numbers the solver counts in.
const WHOLE: i64 = 1 << 60;
/// Share of the moved mass below which a pixel is left out: rounding, not light.
const CRUMB: f64 = 1e-9;
const NONE: u32 = u32::MAX;

/// The exact transport distance between two highlights, in **degrees**: how far light must turn, on average over
/// all the light in the image, to change `a` into `b`. 0: the same highlight. A highlight that is right but for
/// a shift by 1° reads 1. Unlike a difference of pixels it tells a near miss from a far one.
///
/// `a` and `b` hold flux per pixel of the image that `view` lays out, in any unit and size: each is resampled by area
/// to `resolution` × `resolution` pixels (64 is customary; twice that takes a hundred times as long) and scaled to
/// sum one, so lost light does not count here. The cost of moving light is the great-circle angle between the
/// directions at the pixel centres.
///
/// Fails if either image holds no light, or a value that is not finite, or if `resolution` is zero.
pub fn exact_w1(
    a: &Raster,
    b: &Raster,
    view: &View,
    resolution: usize,
    progress: &Progress,
) -> Result<f64, MeasureError> {
    let directions: Vec<_> = (0..resolution * resolution).map(|k| pixel_direction(view, k, resolution)).collect();
    let share = |image: &Raster| -> Result<Vec<f64>, MeasureError> {
        let mut coarse = image.resampled(resolution, resolution).values;
        // Light where no direction projects has nowhere to be moved from.
        coarse.iter_mut().zip(&directions).filter(|(_, d)| d.is_none()).for_each(|(v, _)| *v = 0.0);
        let sum: f64 = coarse.iter().sum();
        let sound = sum > 0.0 && sum.is_finite() && image.values.iter().all(|v| v.is_finite());
        if sound { Ok(coarse.iter().map(|v| v / sum).collect()) } else { Err(MeasureError::NoLight) }
    };
    let (a, b) = (share(a)?, share(b)?);
    // The angle is a metric: what both images share need not move.
    let surplus: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (a - b).max(0.0)).collect();
    let lack: Vec<f64> = a.iter().zip(&b).map(|(a, b)| (b - a).max(0.0)).collect();
    let moved: f64 = surplus.iter().sum();
    if moved < 1e-12 {
        return Ok(0.0); // equal but for rounding
    }
    let worth_moving = |masses: &[f64]| -> (Vec<_>, Vec<f64>) {
        let chosen = masses.iter().zip(&directions).filter(|(mass, _)| **mass > CRUMB * moved);
        chosen.filter_map(|(mass, d)| d.map(|d| (d, *mass))).unzip()
    };
    let (from, supply) = worth_moving(&surplus);
    let (to, demand) = worth_moving(&lack);
    let mut cost = vec![0.0; from.len() * to.len()];
    cost.par_chunks_mut(to.len().max(1)).zip(&from).try_for_each(|(row, &from)| {
        for (cost, &to) in row.iter_mut().zip(&to) {
            *cost = angle_between(from, to).to_degrees();
        }
        progress.check()
    })?;
    let mut tree = Tree::new(&counted(&supply), &counted(&demand), cost, progress)?;
    tree.optimise(progress)?;
    Ok(tree.total_cost() / WHOLE as f64 * moved)
}

/// Where the light of pixel `k` of `resolution` × `resolution` goes.
///
/// A coarse pixel astride the orthographic horizon may hold light although its centre shows no direction; the centre
/// stands for it as it lies, in the plane of the plate.
fn pixel_direction(view: &View, k: usize, resolution: usize) -> Option<DVec3> {
    let uv = View::pixel_centre(k % resolution, k / resolution, resolution, resolution);
    view.inverse(uv).or_else(|| {
        let beyond = uv * view.half_field().sin() + view.centre().truncate();
        (view.projection() == Projection::Orthographic).then(|| beyond.extend(0.0))
    })
}

/// `masses` in whole numbers that sum to exactly [`WHOLE`].
fn counted(masses: &[f64]) -> Vec<i64> {
    let sum: f64 = masses.iter().sum();
    let mut counts: Vec<i64> = masses.iter().map(|m| (m / sum * WHOLE as f64).round() as i64).collect();
    let rest = WHOLE - counts.iter().sum::<i64>();
    if let Some(largest) = counts.iter_mut().max() {
        *largest += rest; // a few parts in 2^53 of the whole, and the largest of n masses is at least 1/n of it
    }
    counts
}

/// A spanning tree of sources (nodes 0..sources), sinks (after them) and one root (last): the basis of the simplex.
///
/// Every arc leads from a source to a sink, so the kind of a node tells how the arc to its parent points: up from a
/// source, down to a sink. A source may also hang from the root, by an arc that costs and carries nothing.
struct Tree {
    sources: usize,
    sinks: usize,
    /// Row-major, a row for each source.
    cost: Vec<f64>,
    parent: Vec<u32>,
    /// Flow on the arc to the parent.
    flow: Vec<i64>,
    depth: Vec<u32>,
    /// Children as linked lists: `link[node]` is the next sibling, `link[nodes + node]` the first child.
    link: Vec<u32>,
    /// Dual prices: price of source + price of sink = cost on every arc of the tree.
    price: Vec<f64>,
    /// Where the search for an entering arc goes on.
    row: usize,
    /// A reduced cost is negative only below minus this.
    tolerance: f64,
}

impl Tree {
    /// A first tree: each source in turn serves the nearest sinks that still lack something. `supply` and `demand`
    /// are positive and of equal sum.
    fn new(supply: &[i64], demand: &[i64], cost: Vec<f64>, progress: &Progress) -> Result<Self, Cancelled> {
        let (sources, sinks) = (supply.len(), demand.len());
        let nodes = sources + sinks + 1;
        let mut tree = Self {
            sources,
            sinks,
            tolerance: 1e-11 * cost.iter().copied().fold(0.0, f64::max),
            cost,
            parent: vec![NONE; nodes],
            flow: vec![0; nodes],
            depth: vec![0; nodes],
            link: vec![NONE; 2 * nodes],
            price: vec![0.0; nodes],
            row: 0,
        };
        // Each shipment settles a source or a sink for good, so the arcs used are a forest.
        let mut arcs = vec![Vec::new(); nodes];
        let (mut lacking, mut open) = (demand.to_vec(), (0..sinks).collect::<Vec<_>>());
        for (i, mut left) in supply.iter().copied().enumerate() {
            progress.check()?;
            while left > 0 {
                let cost = |k: &usize| tree.cost[i * sinks + open[*k]];
                let Some(k) = (0..open.len()).min_by(|a, b| cost(a).total_cmp(&cost(b))) else { break };
                let j = open[k];
                let shipped = left.min(lacking[j]);
                arcs[i].push((sources + j, shipped));
                arcs[sources + j].push((i, shipped));
                left -= shipped;
                lacking[j] -= shipped;
                if lacking[j] == 0 {
                    open.swap_remove(k);
                }
            }
        }
        // Hung from the root by a source, a component keeps the tree strongly feasible: its idle arc points up.
        let mut stack = Vec::new();
        for i in 0..sources {
            if tree.parent[i] == NONE {
                tree.attach(i, nodes - 1, 0);
                stack.push(i);
            }
            while let Some(node) = stack.pop() {
                for &(other, flow) in &arcs[node] {
                    if tree.parent[other] == NONE {
                        tree.attach(other, node, flow);
                        stack.push(other);
                    }
                }
            }
        }
        tree.set_prices();
        Ok(tree)
    }

    fn attach(&mut self, node: usize, parent: usize, flow: i64) {
        self.link[node] = std::mem::replace(&mut self.link[self.parent.len() + parent], node as u32);
        self.parent[node] = parent as u32;
        self.flow[node] = flow;
    }

    fn detach(&mut self, node: usize) {
        let mut at = self.parent.len() + self.parent[node] as usize;
        while self.link[at] as usize != node {
            at = self.link[at] as usize;
        }
        self.link[at] = self.link[node];
    }

    /// Visits `top` and all below it, parents first.
    fn each_below(&mut self, top: usize, mut visit: impl FnMut(&mut Self, usize)) {
        let (nodes, mut node) = (self.parent.len(), top);
        loop {
            visit(self, node);
            let mut onward = self.link[nodes + node];
            while onward == NONE && node != top {
                onward = self.link[node];
                node = self.parent[node] as usize;
            }
            if onward == NONE {
                return;
            }
            node = onward as usize;
        }
    }

    /// Cost of the arc from `node` to its parent.
    fn arc_cost(&self, node: usize) -> f64 {
        let parent = self.parent[node] as usize;
        let (source, sink) = (node.min(parent), node.max(parent) - self.sources);
        if sink < self.sinks { self.cost[source * self.sinks + sink] } else { 0.0 }
    }

    /// Depths and prices of the whole tree, afresh.
    fn set_prices(&mut self) {
        let root = self.sources + self.sinks;
        self.each_below(root, |tree, node| {
            if node != root {
                let parent = tree.parent[node] as usize;
                tree.depth[node] = tree.depth[parent] + 1;
                tree.price[node] = tree.arc_cost(node) - tree.price[parent];
            }
        });
    }

    /// Pivots until no arc can lower the cost.
    fn optimise(&mut self, progress: &Progress) -> Result<(), Cancelled> {
        const PIVOTS_A_QUESTION: usize = 64;
        let (mut stale, mut pivots) = (0, 0usize);
        loop {
            pivots += 1;
            if pivots.is_multiple_of(PIVOTS_A_QUESTION) {
                progress.check()?;
            }
            let entering = self.entering();
            if stale > 0 && (entering.is_none() || stale == self.price.len()) {
                // Prices have been added to many times: rounding must neither grow nor have the last word.
                self.set_prices();
                stale = 0;
            } else if let Some((i, j, reduced)) = entering {
                self.pivot(i, self.sources + j, reduced);
                stale += 1;
            } else {
                return Ok(());
            }
        }
    }

    /// The arc (source, sink) of most negative reduced cost in the next row that has one, and that cost.
    /// Looking through more rows saves pivots, but takes longer than they do.
    fn entering(&mut self) -> Option<(usize, usize, f64)> {
        let prices = &self.price[self.sources..][..self.sinks];
        for _ in 0..self.sources {
            let i = self.row;
            self.row = if i + 1 == self.sources { 0 } else { i + 1 };
            let row = &self.cost[i * self.sinks..][..self.sinks];
            let least = least_difference(row, prices);
            if least - self.price[i] < -self.tolerance {
                let j = row.iter().zip(prices).position(|(c, p)| c - p == least)?;
                return Some((i, j, least - self.price[i]));
            }
        }
        None
    }

    /// Arc `i` → `j` enters the tree, the arc that its cycle empties leaves.
    fn pivot(&mut self, i: usize, j: usize, reduced: f64) {
        // Flow is pushed from the cycle's apex down to i, on to j and back up. It drains the arcs of sources above i
        // and of sinks above j. Of the arcs that run dry first, the last one met on that way leaves (Cunningham).
        let (mut x, mut y) = (i, j);
        let (mut pushed, mut leaving, mut above_i) = (i64::MAX, i, true);
        while x != y {
            if self.depth[x] >= self.depth[y] {
                if x < self.sources && self.flow[x] < pushed {
                    (pushed, leaving, above_i) = (self.flow[x], x, true);
                }
                x = self.parent[x] as usize;
            } else {
                if y >= self.sources && self.flow[y] <= pushed {
                    (pushed, leaving, above_i) = (self.flow[y], y, false);
                }
                y = self.parent[y] as usize;
            }
        }
        if pushed > 0 {
            for (start, sign) in [(i, -1), (j, 1)] {
                let mut node = start;
                while node != x {
                    self.flow[node] += if node < self.sources { sign * pushed } else { -sign * pushed };
                    node = self.parent[node] as usize;
                }
            }
        }
        // What hung by the leaving arc now hangs by the entering one: the way between them turns over.
        let (top, holder) = if above_i { (i, j) } else { (j, i) };
        let (mut node, mut parent, mut flow) = (top, holder, pushed);
        loop {
            let (old_parent, old_flow) = (self.parent[node] as usize, self.flow[node]);
            self.detach(node);
            self.attach(node, parent, flow);
            if node == leaving {
                break;
            }
            (parent, node, flow) = (node, old_parent, old_flow);
        }
        self.each_below(top, |tree, node| {
            tree.depth[node] = tree.depth[tree.parent[node] as usize] + 1;
            tree.price[node] += if (node < tree.sources) == above_i { reduced } else { -reduced };
        });
    }

    /// Cost of the flow, in degrees times [`WHOLE`].
    fn total_cost(&self) -> f64 {
        (0..self.sources + self.sinks).map(|node| self.flow[node] as f64 * self.arc_cost(node)).sum()
    }
}

/// The least of `row[j] - prices[j]`, in lanes that the compiler can run side by side.
fn least_difference(row: &[f64], prices: &[f64]) -> f64 {
    const LANES: usize = 8;
    let mut least = [f64::INFINITY; LANES];
    let (rows, prices) = (row.chunks_exact(LANES), prices.chunks_exact(LANES));
    let rest = rows.remainder().iter().zip(prices.remainder()).map(|(c, p)| c - p).fold(f64::INFINITY, f64::min);
    for (row, prices) in rows.zip(prices) {
        for lane in 0..LANES {
            let difference = row[lane] - prices[lane];
            least[lane] = if difference < least[lane] { difference } else { least[lane] };
        }
    }
    least.into_iter().fold(rest, f64::min)
}

#[cfg(test)]
mod tests;
