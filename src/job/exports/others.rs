//! The files of everything that is no design.

/// Every file that a verification may write.
pub const VERIFY: &[&str] = &[
    "target.png",
    "simulated.png",
    "comparison.png",
    "comparison_milled.png",
    "comparison_made.png",
    "goal.png",
    "as-made.stl",
    "report.json",
];

/// Every file that a plan may write.
pub const PLAN: &[&str] = &["plan.png", "recipe-1.toml", "recipe-2.toml", "recipe-3.toml", "report.json"];

/// Every file that a fit may write.
pub const FIT: &[&str] = &["fit.png", "fit_2.png", "fit_3.png", "report.json"];

/// Every file that any measurement may write.
pub const MEASURE: &[&str] = &[
    "highlight.png",
    "highlight.tiff",
    "highlight_error.tiff",
    "brdf.bsdf",
    "brdf.binary",
    "brdf.csv",
    "slices.png",
    "maps.png",
    "ndf.png",
    "ndf.csv",
    "masking.csv",
    "wall.png",
    "wall.tiff",
    "wall_error.tiff",
    "look.png",
    "look.tiff",
    "look_error.tiff",
    "report.json",
];

/// The programs of a machine, whatever its control, and the files beside them.
macro_rules! with_programs {
    ($($name:literal),+) => {
        &[
            "air-cut.nc",
            "air-cut.ngc",
            "air-cut.tap",
            "roughing.nc",
            "roughing.ngc",
            "roughing.tap",
            "finishing.nc",
            "finishing.ngc",
            "finishing.tap",
            $($name),+
        ]
    };
}

/// Every file that `mill` may write.
pub const MILL: &[&str] = with_programs!("comparison_made.png", "setup.html", "report.json");

/// Every file that `coupon` may write.
pub const COUPON: &[&str] = with_programs!("coupon.toml", "plate.stl", "setup.html", "report.json");

/// Every file that `coupon --read` may write.
pub const COUPON_READ: &[&str] = &["machine.toml", "report.json"];

/// Every file that `mill --check` may write.
pub const CHECK: &[&str] = &["target.png", "comparison.png", "report.json"];
