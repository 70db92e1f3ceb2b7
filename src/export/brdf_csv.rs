//! A BRDF table as text, for spreadsheets and one's own programs.

use std::io::{self, Write};

use crate::slope::mirror;
use crate::verify::goniometer::table::BrdfTable;

/// Writes one line for each incident direction and each cell that light can leave through: the angles of light and
/// viewer in degrees (azimuths from -180 to 180, the viewer at the middle of the cell), the mean BRDF of the cell and
/// its standard error in 1/sr. Lines that begin with # explain.
///
/// Cells whose middle lies below the horizon are left out, even if a part of them does not; so are those without light.
pub fn write_brdf_csv(table: &BrdfTable, out: &mut impl Write) -> io::Result<()> {
    let axes = table.axes();
    writeln!(out, "# BRDF of a plate; z is its normal, phi counts from x toward y, seen from above")?;
    writeln!(out, "# theta_i, phi_i: toward the light; theta_o, phi_o: toward the viewer; degrees")?;
    writeln!(
        out,
        "# brdf: mean over the cell of half vectors around that viewer, error: its standard error; 1/sr; no line: 0"
    )?;
    if axes.is_isotropic() {
        writeln!(out, "# isotropic: other phi_i follow by turning light and viewer together")?;
    }
    writeln!(
        out,
        "# {} polar angles x {} azimuths of incidence, {} x {} cells of half vectors (sqrt of polar angle x azimuth)",
        axes.theta_i().len(),
        axes.phi_i().len(),
        axes.columns(),
        axes.rows()
    )?;
    writeln!(out, "theta_i,phi_i,theta_o,phi_o,brdf,error")?;
    for slice in 0..axes.slices() {
        let (theta_i, phi_i) = axes.incident_angles(slice);
        let l = axes.incident(slice);
        for (cell, (value, error)) in table.slice(slice).iter().zip(table.slice_error(slice)).enumerate() {
            let u = ((cell % axes.columns()) as f64 + 0.5) / axes.columns() as f64;
            let v = ((cell / axes.columns()) as f64 + 0.5) / axes.rows() as f64;
            let m = axes.half_vector(slice, u, v);
            let o = mirror(l, m);
            if value.is_nan() || (*value == 0.0 && *error == 0.0) || o.z <= 0.0 || l.dot(m) <= 0.0 {
                continue;
            }
            writeln!(
                out,
                "{:.4},{:.4},{:.4},{:.4},{value:e},{error:e}",
                theta_i.to_degrees(),
                phi_i.to_degrees(),
                o.x.hypot(o.y).atan2(o.z).to_degrees(),
                o.y.atan2(o.x).to_degrees(),
            )?;
        }
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::slope::direction;
    use crate::verify::goniometer::table::BrdfAxes;

    #[test]
    fn every_line_says_what_the_brdf_is_there() {
        let f = |wi: glam::DVec3, wo: glam::DVec3| 0.3 + 0.1 * wi.x * wo.y + 0.05 * wo.z;
        let axes = BrdfAxes::anisotropic(vec![0.0, 0.5, 1.0], 4, 40, 40).unwrap();
        let mut text = Vec::new();
        write_brdf_csv(&BrdfTable::from_fn(axes, f), &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let lines: Vec<&str> = text.lines().filter(|line| !line.starts_with('#')).collect();
        assert_eq!(lines[0], "theta_i,phi_i,theta_o,phi_o,brdf,error");
        assert!(lines.len() > 12 * 400 && lines.len() < 12 * 1600);
        for line in &lines[1..] {
            let n: Vec<f64> = line.split(',').map(|v| v.parse().unwrap()).collect();
            assert_eq!((n.len(), n[5]), (6, 0.0));
            let at = |theta: f64, phi: f64| direction(theta.to_radians(), phi.to_radians());
            let wanted = f(at(n[0], n[1]), at(n[2], n[3]));
            // The mean of a cell is that of its middle, up to the square of its size.
            assert!((n[4] - wanted).abs() < 0.01, "{line} {wanted}");
        }
        let polar: std::collections::BTreeSet<&str> = lines[1..].iter().map(|l| l.split(',').next().unwrap()).collect();
        assert_eq!(polar.into_iter().collect::<Vec<_>>(), ["0.0000", "28.6479", "57.2958"]);
    }
}
