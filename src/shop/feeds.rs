//! Feeds and speeds to start from.
//!
//! They are the lower ends of a cutter maker's table for solid carbide end mills (G. W. Schultz Tool, "Speeds and feeds",
//! gwschultz.com): surface speeds, and the feed of a tooth of 1/8 inch as a share of the diameter. Cutter, machine, coolant
//! and clamping decide more than any table: what is written in a program is where to start.

use std::fmt;
use std::str::FromStr;

use crate::cutter::Cutter;
use crate::milling::machine::Machine;

/// What a plate is cut from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Stock {
    /// How it is called.
    pub name: &'static str,
    /// Surface speed of a carbide cutter, m/min.
    pub surface_speed: f64,
    /// Feed of a tooth as a share of the cutter's diameter.
    pub chip: f64,
}

/// Every stock that is known, feet and inches of the table turned into m/min and shares.
pub const STOCKS: [Stock; 5] = [
    Stock { name: "aluminium", surface_speed: 260.0, chip: 0.008 },
    Stock { name: "brass", surface_speed: 120.0, chip: 0.008 },
    Stock { name: "copper", surface_speed: 140.0, chip: 0.008 },
    // Steel of up to 35 HRC.
    Stock { name: "steel", surface_speed: 45.0, chip: 0.004 },
    Stock { name: "plastic", surface_speed: 240.0, chip: 0.016 },
];

/// Where the figures are from, in a sentence for people.
pub const SOURCE: &str =
    "starting values, from the carbide table of G. W. Schultz Tool: machine, clamping and coolant decide";

/// Depth of one level of roughing, and from one of its passes to the next, as shares of the cutter's diameter; usual for
/// light machines, and to be raised where there is more power.
const LEVEL: f64 = 0.1;
const ASIDE: f64 = 0.4;

/// Share of the feed at which a cutter goes down.
const PLUNGE: f64 = 1.0 / 3.0;

/// Share of a machine's rapids that a roughing feed may reach.
const FASTEST: f64 = 0.5;

/// A spindle and its cutter.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Spindle {
    /// Most turns a minute.
    pub fastest: f64,
    /// Teeth of the cutter.
    pub teeth: f64,
}

/// How fast a cutter turns and goes.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Pace {
    /// mm/min.
    pub feed: f64,
    /// mm/min, downward.
    pub plunge: f64,
    /// Turns a minute.
    pub speed: f64,
}

impl Stock {
    /// Most turns a minute of a cutter, by its largest diameter.
    fn speed(&self, cutter: Cutter, spindle: Spindle) -> f64 {
        (1000.0 * self.surface_speed / (std::f64::consts::PI * cutter.diameter())).min(spindle.fastest)
    }

    /// For finishing: no faster than `machine`'s feed, and so that its teeth cut as far apart as it is said of it, or as
    /// chips want where nothing is said.
    pub fn finishing(&self, cutter: Cutter, machine: &Machine, spindle: Spindle) -> Pace {
        let tooth =
            if machine.feed_per_tooth > 0.0 { machine.feed_per_tooth } else { self.chip * cutter.tip_diameter() };
        let a_turn = tooth * spindle.teeth;
        let speed = self.speed(cutter, spindle).min(machine.feed / a_turn);
        let feed = machine.feed.min(speed * a_turn);
        Pace { feed, plunge: PLUNGE * feed, speed }
    }

    /// For roughing.
    pub fn roughing(&self, cutter: Cutter, machine: &Machine, spindle: Spindle) -> Pace {
        let speed = self.speed(cutter, spindle);
        let feed = (speed * spindle.teeth * self.chip * cutter.diameter()).min(FASTEST * machine.rapid);
        Pace { feed, plunge: PLUNGE * feed, speed }
    }
}

/// From one level of roughing to the next, and from one of its passes to the next, mm.
pub fn bites(cutter: Cutter) -> [f64; 2] {
    [LEVEL * cutter.diameter(), ASIDE * cutter.diameter()]
}

impl fmt::Display for Stock {
    fn fmt(&self, out: &mut fmt::Formatter<'_>) -> fmt::Result {
        out.write_str(self.name)
    }
}

impl FromStr for Stock {
    type Err = UnknownStock;

    fn from_str(text: &str) -> Result<Self, UnknownStock> {
        let name = match text {
            "aluminum" => "aluminium",
            "acrylic" => "plastic",
            name => name,
        };
        STOCKS.into_iter().find(|stock| stock.name == name).ok_or_else(|| UnknownStock(text.to_owned()))
    }
}

/// Not a stock.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
#[error("'{0}' is no stock whose speeds are known: write aluminium, brass, copper, steel or plastic")]
pub struct UnknownStock(String);

#[cfg(test)]
mod tests {
    use super::*;

    const SPINDLE: Spindle = Spindle { fastest: 24_000.0, teeth: 2.0 };

    #[test]
    fn stocks_are_written_as_they_are_read() {
        for stock in STOCKS {
            assert_eq!(stock.to_string().parse(), Ok(stock));
        }
        assert!("cheese".parse::<Stock>().unwrap_err().to_string().contains("aluminium, brass"));
    }

    #[test]
    fn teeth_cut_as_far_apart_as_the_machine_says_whatever_the_spindle_allows() {
        let stock: Stock = "aluminium".parse().unwrap();
        let pace = stock.finishing(Cutter::ball(0.5), &Machine::preset("desktop").unwrap(), SPINDLE);
        assert!((pace.feed - 600.0).abs() < 1e-9 && (pace.speed - 20_000.0).abs() < 1e-6, "{pace:?}");
        // 5 µm a tooth at 600 mm/min would be 60000 turns: the feed gives way.
        let pace = stock.finishing(Cutter::ball(0.5), &Machine::preset("vmc-good").unwrap(), SPINDLE);
        assert!((pace.feed - 240.0).abs() < 1e-9 && (pace.speed - 24_000.0).abs() < 1e-6, "{pace:?}");
    }

    #[test]
    fn a_large_cutter_in_steel_turns_as_slowly_as_its_rim_wants() {
        let stock: Stock = "steel".parse().unwrap();
        let pace = stock.roughing("flat:6".parse().unwrap(), &Machine::preset("vmc").unwrap(), SPINDLE);
        let turns = 45_000.0 / (6.0 * std::f64::consts::PI);
        assert!((pace.speed - turns).abs() < 1e-6 && (pace.feed - turns * 2.0 * 0.024).abs() < 1e-6, "{pace:?}");
    }
}
