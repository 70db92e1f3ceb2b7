//! Complex indices of refraction of the metals a shop cuts or plates, as published.
//!
//! The rows are those of the named papers in the visible range, as collected in the refractiveindex.info database
//! (M. N. Polyanskiy, public domain); nothing is fitted or smoothed. They hold for clean, optically smooth metal: a
//! tarnished or anodised face is darker.

/// A metal of the table.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[non_exhaustive]
pub enum Metal {
    /// Evaporated aluminium. A. D. Rakić, Appl. Opt. 34, 4755 (1995).
    Aluminium,
    /// 70 % copper, 30 % zinc. M. R. Querry, Optical constants, Contractor Report CRDC-CR-85034 (1985), every second row.
    Brass,
    /// Chromium. P. B. Johnson and R. W. Christy, Phys. Rev. B 9, 5056 (1974).
    Chrome,
    /// Copper. P. B. Johnson and R. W. Christy, Phys. Rev. B 6, 4370 (1972).
    Copper,
    /// Gold. P. B. Johnson and R. W. Christy, Phys. Rev. B 6, 4370 (1972).
    Gold,
    /// Iron. P. B. Johnson and R. W. Christy, Phys. Rev. B 9, 5056 (1974).
    Iron,
    /// Nickel. P. B. Johnson and R. W. Christy, Phys. Rev. B 9, 5056 (1974).
    Nickel,
    /// Silver. P. B. Johnson and R. W. Christy, Phys. Rev. B 6, 4370 (1972).
    Silver,
    /// Ferritic stainless steel with 13.5 % chromium. B. Karlsson and C. G. Ribbing, J. Appl. Phys. 53, 6340 (1982),
    /// read off their figure.
    Steel,
}

impl Metal {
    /// All metals, by name.
    pub const ALL: [Self; 9] = [
        Self::Aluminium,
        Self::Brass,
        Self::Chrome,
        Self::Copper,
        Self::Gold,
        Self::Iron,
        Self::Nickel,
        Self::Silver,
        Self::Steel,
    ];

    /// The wavelengths, nm, that every metal of the table covers.
    pub const WAVELENGTHS: std::ops::RangeInclusive<f64> = 400.0..=750.0;

    /// Its name in flags and recipes.
    pub const fn name(self) -> &'static str {
        match self {
            Self::Aluminium => "aluminium",
            Self::Brass => "brass",
            Self::Chrome => "chrome",
            Self::Copper => "copper",
            Self::Gold => "gold",
            Self::Iron => "iron",
            Self::Nickel => "nickel",
            Self::Silver => "silver",
            Self::Steel => "steel",
        }
    }

    /// The metal called `name`, in lower case; `aluminum`, `chromium` and `stainless` are understood too.
    pub fn named(name: &str) -> Option<Self> {
        match name {
            "aluminum" => Some(Self::Aluminium),
            "chromium" => Some(Self::Chrome),
            "stainless" => Some(Self::Steel),
            _ => Self::ALL.into_iter().find(|metal| metal.name() == name),
        }
    }

    /// Where the numbers come from.
    pub const fn source(self) -> &'static str {
        match self {
            Self::Aluminium => "A. D. Rakić, Appl. Opt. 34, 4755 (1995)",
            Self::Brass => "M. R. Querry, Contractor Report CRDC-CR-85034 (1985), Cu70Zn30",
            Self::Copper | Self::Gold | Self::Silver => "P. B. Johnson and R. W. Christy, Phys. Rev. B 6, 4370 (1972)",
            Self::Chrome | Self::Iron | Self::Nickel => "P. B. Johnson and R. W. Christy, Phys. Rev. B 9, 5056 (1974)",
            Self::Steel => "B. Karlsson and C. G. Ribbing, J. Appl. Phys. 53, 6340 (1982), ferritic stainless",
        }
    }

    /// The complex index of refraction (eta, k) at `wavelength` nm, linear between the published rows; outside
    /// [`Self::WAVELENGTHS`] it stays at the last row.
    pub fn at(self, wavelength: f64) -> (f64, f64) {
        let rows = self.rows();
        let after = rows.partition_point(|row| row.0 <= wavelength).clamp(1, rows.len() - 1);
        let (low, high) = (rows[after - 1], rows[after]);
        let t = ((wavelength - low.0) / (high.0 - low.0)).clamp(0.0, 1.0);
        (low.1 + t * (high.1 - low.1), low.2 + t * (high.2 - low.2))
    }

    const fn rows(self) -> &'static [Row] {
        match self {
            Self::Aluminium => ALUMINIUM,
            Self::Brass => BRASS,
            Self::Chrome => CHROME,
            Self::Copper => COPPER,
            Self::Gold => GOLD,
            Self::Iron => IRON,
            Self::Nickel => NICKEL,
            Self::Silver => SILVER,
            Self::Steel => STEEL,
        }
    }
}

/// Wavelength nm, eta, k.
type Row = (f64, f64, f64);

#[rustfmt::skip]
const ALUMINIUM: &[Row] = &[
    (364.66, 0.39877, 4.3957), (413.28, 0.52135, 5.0008), (442.8, 0.6079, 5.3676), (476.87, 0.7278, 5.7781), (516.6, 0.8734, 6.2418),
    (563.57, 1.0728, 6.7839), (619.93, 1.366, 7.4052), (652.25, 1.5724, 7.7354), (688.81, 1.8301, 8.0601), (729.32, 2.1606, 8.3565),
    (774.91, 2.6154, 8.4914),
];

#[rustfmt::skip]
const BRASS: &[Row] = &[
    (400.0, 1.445, 1.805), (420.0, 1.35, 1.786), (440.0, 1.191, 1.797), (460.0, 0.994, 1.883), (480.0, 0.816, 2.046),
    (500.0, 0.686, 2.25), (520.0, 0.602, 2.464), (540.0, 0.549, 2.668), (560.0, 0.505, 2.86), (580.0, 0.468, 3.059),
    (600.0, 0.45, 3.253), (620.0, 0.449, 3.434), (640.0, 0.444, 3.609), (660.0, 0.445, 3.778), (680.0, 0.444, 3.943),
    (700.0, 0.446, 4.106), (720.0, 0.45, 4.266), (740.0, 0.455, 4.424), (760.0, 0.458, 4.579),
];

#[rustfmt::skip]
#[allow(clippy::approx_constant)] // a measured 3.14
const CHROME: &[Row] = &[
    (397.0, 2.0, 2.83), (413.0, 2.08, 2.93), (431.0, 2.19, 3.04), (451.0, 2.33, 3.14), (471.0, 2.51, 3.24),
    (496.0, 2.75, 3.3), (521.0, 2.94, 3.33), (549.0, 3.18, 3.33), (582.0, 3.22, 3.3), (617.0, 3.17, 3.3),
    (659.0, 3.09, 3.34), (704.0, 3.05, 3.39), (756.0, 3.08, 3.42),
];

#[rustfmt::skip]
const COPPER: &[Row] = &[
    (397.4, 1.32, 2.116), (413.3, 1.28, 2.207), (430.5, 1.25, 2.305), (450.9, 1.24, 2.397), (471.4, 1.25, 2.483),
    (495.9, 1.22, 2.564), (520.9, 1.18, 2.608), (548.6, 1.02, 2.577), (582.1, 0.7, 2.704), (616.8, 0.3, 3.205),
    (659.5, 0.22, 3.747), (704.5, 0.21, 4.205), (756.0, 0.24, 4.665),
];

#[rustfmt::skip]
const GOLD: &[Row] = &[
    (397.4, 1.47, 1.952), (413.3, 1.46, 1.958), (430.5, 1.45, 1.948), (450.9, 1.38, 1.914), (471.4, 1.31, 1.849),
    (495.9, 1.04, 1.833), (520.9, 0.62, 2.081), (548.6, 0.43, 2.455), (582.1, 0.29, 2.863), (616.8, 0.21, 3.272),
    (659.5, 0.14, 3.697), (704.5, 0.13, 4.103), (756.0, 0.14, 4.542),
];

#[rustfmt::skip]
const IRON: &[Row] = &[
    (397.0, 2.24, 2.58), (413.0, 2.35, 2.65), (431.0, 2.48, 2.71), (451.0, 2.59, 2.77), (471.0, 2.67, 2.82),
    (496.0, 2.74, 2.88), (521.0, 2.86, 2.91), (549.0, 2.95, 2.93), (582.0, 2.94, 2.99), (617.0, 2.88, 3.05),
    (659.0, 2.92, 3.1), (704.0, 2.86, 3.19), (756.0, 2.87, 3.28),
];

#[rustfmt::skip]
const NICKEL: &[Row] = &[
    (397.0, 1.72, 2.57), (413.0, 1.7, 2.69), (431.0, 1.71, 2.82), (451.0, 1.73, 2.95), (471.0, 1.78, 3.09),
    (496.0, 1.82, 3.25), (521.0, 1.85, 3.42), (549.0, 1.92, 3.61), (582.0, 1.96, 3.8), (617.0, 1.99, 4.02),
    (659.0, 1.99, 4.26), (704.0, 2.06, 4.5), (756.0, 2.13, 4.73),
];

#[rustfmt::skip]
const SILVER: &[Row] = &[
    (397.4, 0.05, 2.07), (413.3, 0.05, 2.275), (430.5, 0.04, 2.462), (450.9, 0.04, 2.657), (471.4, 0.05, 2.869),
    (495.9, 0.05, 3.093), (520.9, 0.05, 3.324), (548.6, 0.06, 3.586), (582.1, 0.05, 3.858), (616.8, 0.06, 4.152),
    (659.5, 0.05, 4.483), (704.5, 0.04, 4.838), (756.0, 0.03, 5.242),
];

#[rustfmt::skip]
const STEEL: &[Row] = &[
    (400.0, 1.3075, 2.534), (420.0, 1.3766, 2.6334), (440.0, 1.4517, 2.7256), (460.0, 1.5372, 2.8162), (480.0, 1.6307, 2.9055),
    (500.0, 1.7244, 2.9919), (520.0, 1.8059, 3.0721), (540.0, 1.873, 3.1404), (560.0, 1.9355, 3.2004), (580.0, 1.9969, 3.2617),
    (600.0, 2.0565, 3.3248), (620.0, 2.1139, 3.3881), (640.0, 2.1685, 3.4507), (660.0, 2.2199, 3.5118), (680.0, 2.2679, 3.5707),
    (700.0, 2.3124, 3.6273), (720.0, 2.3536, 3.6821), (740.0, 2.3917, 3.7354), (760.0, 2.4268, 3.7877),
];

#[cfg(test)]
mod tests {
    use super::super::fresnel::conductor;
    use super::*;

    #[test]
    fn reflectances_are_those_commonly_quoted() {
        // Normal incidence at 450, 550 and 650 nm, rounded; clean samples of different makers differ by a few per cent.
        let known = [
            (Metal::Aluminium, [0.92, 0.92, 0.91], 0.01),
            (Metal::Silver, [0.97, 0.98, 0.99], 0.015),
            (Metal::Gold, [0.39, 0.82, 0.96], 0.04),
            (Metal::Copper, [0.55, 0.62, 0.95], 0.04),
            (Metal::Brass, [0.44, 0.80, 0.89], 0.05),
            (Metal::Chrome, [0.56, 0.55, 0.56], 0.02),
            (Metal::Iron, [0.50, 0.52, 0.53], 0.04),
            (Metal::Nickel, [0.57, 0.63, 0.70], 0.03),
            (Metal::Steel, [0.56, 0.59, 0.62], 0.03),
        ];
        for (metal, expected, tolerance) in known {
            for (wavelength, expected) in [450.0, 550.0, 650.0].into_iter().zip(expected) {
                let (eta, k) = metal.at(wavelength);
                let got = conductor(1.0, eta, k);
                assert!((got - expected).abs() <= tolerance, "{} {wavelength}: {got:.3}", metal.name());
            }
        }
    }

    #[test]
    fn published_rows_come_back_and_the_middle_is_between() {
        assert_eq!(Metal::Gold.at(520.9), (0.62, 2.081));
        let (eta, k) = Metal::Steel.at(550.0);
        assert!((eta - 0.5 * (1.873 + 1.9355)).abs() < 1e-12 && (k - 0.5 * (3.1404 + 3.2004)).abs() < 1e-12);
        assert_eq!(Metal::Brass.at(100.0), (1.445, 1.805));
        assert_eq!(Metal::Brass.at(1e9), (0.458, 4.579));
    }

    #[test]
    fn tables_climb_and_cover_the_promised_range() {
        for metal in Metal::ALL {
            let rows = metal.rows();
            assert!(rows.windows(2).all(|pair| pair[0].0 < pair[1].0), "{metal:?}");
            assert!(rows[0].0 <= *Metal::WAVELENGTHS.start() && rows[rows.len() - 1].0 >= *Metal::WAVELENGTHS.end());
            assert_eq!(Metal::named(metal.name()), Some(metal));
            assert!(metal.source().contains('('));
        }
        assert_eq!(Metal::named("aluminum"), Some(Metal::Aluminium));
        assert_eq!(Metal::named("unobtainium"), None);
    }
}
