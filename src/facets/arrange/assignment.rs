//! The cheapest assignment of n workers to n places, exactly.

use crate::progress::Progress;

/// No row or column.
const FREE: usize = usize::MAX;

/// For each row of the `n` × `n` matrix `cost` (row-major, finite) the column assigned to it, at least total cost.
///
/// Jonker and Volgenant, Computing 38, 1987: column reduction, two passes in which free rows bid for columns, then
/// shortest augmenting paths. Prices of columns are kept so that every assigned row has its cheapest column. O(n³) at
/// worst; on smooth costs the bidding leaves few rows. Told to finish, it gives the rows that are left any columns.
pub fn cheapest_assignment(n: usize, cost: &[f64], progress: &Progress) -> Vec<usize> {
    debug_assert_eq!(cost.len(), n * n);
    if n == 0 {
        return Vec::new();
    }
    let mut market = Market { n, cost, column_of: vec![FREE; n], row_of: vec![FREE; n], price: vec![0.0; n] };
    market.reduce_columns();
    for _ in 0..2 {
        market.bid();
    }
    let mut search = Search { distance: vec![0.0; n], previous: vec![0; n], open: Vec::with_capacity(n) };
    for row in 0..n {
        if market.column_of[row] == FREE {
            if progress.is_to_finish() {
                market.settle();
                break;
            }
            market.augment(row, &mut search);
        }
    }
    market.column_of
}

struct Market<'a> {
    n: usize,
    cost: &'a [f64],
    column_of: Vec<usize>,
    row_of: Vec<usize>,
    price: Vec<f64>,
}

/// Scratch space of the path search.
struct Search {
    distance: Vec<f64>,
    previous: Vec<usize>,
    open: Vec<usize>,
}

impl Market<'_> {
    /// Gives each free row some free column.
    fn settle(&mut self) {
        let mut free = (0..self.n).filter(|&j| self.row_of[j] == FREE);
        for column in self.column_of.iter_mut().filter(|column| **column == FREE) {
            *column = free.next().unwrap_or(0);
        }
    }

    fn row(&self, i: usize) -> &[f64] {
        &self.cost[i * self.n..][..self.n]
    }

    /// Every column's price is its smallest cost; it goes there if that row is still free.
    fn reduce_columns(&mut self) {
        let mut cheapest = vec![0; self.n];
        self.price.fill(f64::INFINITY);
        for (i, row) in self.cost.chunks(self.n).enumerate() {
            for (j, &c) in row.iter().enumerate() {
                if c < self.price[j] {
                    (self.price[j], cheapest[j]) = (c, i);
                }
            }
        }
        for (j, &i) in cheapest.iter().enumerate().rev() {
            if self.column_of[i] == FREE {
                (self.column_of[i], self.row_of[j]) = (j, i);
            }
        }
    }

    /// Free rows take their cheapest column and lower its price until their second choice is as good; whoever is
    /// displaced bids next, or in the next pass if nothing was gained.
    fn bid(&mut self) {
        let free: Vec<usize> = (0..self.n).filter(|&i| self.column_of[i] == FREE).collect();
        // Ties can displace in circles; the paths settle whatever is left.
        let mut left = 4 * self.n;
        for row in free {
            let mut bidder = row;
            while left > 0 {
                left -= 1;
                let (mut first, mut second) = ((f64::INFINITY, 0), (f64::INFINITY, 0));
                for (j, (c, price)) in self.row(bidder).iter().zip(&self.price).enumerate() {
                    let net = c - price;
                    if net < first.0 {
                        second = first;
                        first = (net, j);
                    } else if net < second.0 {
                        second = (net, j);
                    }
                }
                let gain = second.0 - first.0;
                let mut j = first.1;
                if gain > 0.0 && gain.is_finite() {
                    self.price[j] -= gain;
                } else if self.row_of[j] != FREE && self.n > 1 {
                    j = second.1;
                }
                let displaced = std::mem::replace(&mut self.row_of[j], bidder);
                self.column_of[bidder] = j;
                if displaced == FREE {
                    break;
                }
                self.column_of[displaced] = FREE;
                if gain <= 0.0 {
                    break;
                }
                bidder = displaced;
            }
        }
    }

    /// Assigns the free row `start` along the shortest path of reassignments to a free column.
    fn augment(&mut self, start: usize, search: &mut Search) {
        let Search { distance, previous, open } = search;
        for (d, (c, price)) in distance.iter_mut().zip(self.row(start).iter().zip(&self.price)) {
            *d = c - price;
        }
        previous.fill(start);
        open.clear();
        open.extend(0..self.n);
        let mut settled = Vec::new();
        let end = loop {
            let (mut reached, mut nearest) = (f64::INFINITY, 0);
            for (k, &j) in open.iter().enumerate() {
                if distance[j] < reached || (distance[j] == reached && self.row_of[j] == FREE) {
                    (reached, nearest) = (distance[j], k);
                }
            }
            let j = open.swap_remove(nearest);
            if self.row_of[j] == FREE {
                for &k in &settled {
                    self.price[k] += distance[k] - reached;
                }
                break j;
            }
            settled.push(j);
            let row = self.row_of[j];
            let costs = self.row(row);
            let base = reached - (costs[j] - self.price[j]);
            for &k in open.iter() {
                let through = base + costs[k] - self.price[k];
                if through < distance[k] {
                    (distance[k], previous[k]) = (through, row);
                }
            }
        };
        let mut j = end;
        loop {
            let i = previous[j];
            self.row_of[j] = i;
            std::mem::swap(&mut self.column_of[i], &mut j);
            if i == start {
                break;
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn total(n: usize, cost: &[f64], columns: &[usize]) -> f64 {
        columns.iter().enumerate().map(|(i, &j)| cost[i * n + j]).sum()
    }

    /// All orders of 0..n.
    fn permutations(n: usize) -> Vec<Vec<usize>> {
        if n == 0 {
            return vec![vec![]];
        }
        let shorter = permutations(n - 1);
        shorter.iter().flat_map(|p| (0..n).map(move |k| [&p[..k], &[n - 1], &p[k..]].concat())).collect()
    }

    #[test]
    fn no_other_order_is_cheaper() {
        for n in 1..7 {
            for seed in 0..20u64 {
                let value = |k: usize| ((k as u64 + 1) * (seed * 2 + 7919) * 2_654_435_761 % 1000) as f64 / 10.0 - 30.0;
                let cost: Vec<f64> = (0..n * n).map(value).collect();
                let found = total(n, &cost, &cheapest_assignment(n, &cost, &Progress::silent()));
                let best = permutations(n).iter().map(|p| total(n, &cost, p)).fold(f64::INFINITY, f64::min);
                assert!((found - best).abs() < 1e-9, "n {n} seed {seed}: {found} against {best}");
            }
        }
    }

    #[test]
    fn a_planted_order_is_found() {
        let n = 200;
        let place = |i: usize| (i * 77 + 5) % n;
        let cost: Vec<f64> = (0..n * n).map(|k| (place(k / n) as f64 - (k % n) as f64).powi(2)).collect();
        let found = cheapest_assignment(n, &cost, &Progress::silent());
        assert!((0..n).all(|i| found[i] == place(i)));
    }
}
