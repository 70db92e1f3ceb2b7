//! A BRDF table as text, for spreadsheets and one's own programs.

use std::io::{self, Write};

use thiserror::Error;

use crate::slope::{direction, mirror, polar_angle};
use crate::verify::goniometer::table::{BrdfAxes, BrdfTable, TableError};

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
                polar_angle(o).to_degrees(),
                o.y.atan2(o.x).to_degrees(),
            )?;
        }
    }
    Ok(())
}

/// Reads what [`write_brdf_csv`] wrote: the grid from its comments, the cells from its lines; a cell without a line is dark.
///
/// # Errors
/// Text of another kind, numbers that are none, or directions that are not of the grid.
pub fn read_brdf_csv(text: &str) -> Result<BrdfTable, BrdfCsvError> {
    let counts: Vec<usize> = text
        .lines()
        .find(|line| line.starts_with('#') && line.contains("polar angles x"))
        .map(|line| line.split(' ').filter_map(|word| word.parse().ok()).collect())
        .unwrap_or_default();
    let &[polar, azimuths, columns, rows] = counts.as_slice() else { return Err(BrdfCsvError::NoGrid) };
    let mut lines = Vec::new();
    let numbered = text.lines().enumerate().filter(|(_, line)| !line.starts_with('#') && !line.trim().is_empty());
    for (k, line) in numbered.skip(1) {
        let numbers: Option<Vec<f64>> = line.split(',').map(|n| n.trim().parse().ok()).collect();
        match numbers.as_deref() {
            // A measured value may lie below 0 by its own noise.
            Some(&[a, b, c, d, value, error]) if value.is_finite() && (0.0..f64::INFINITY).contains(&error) => {
                lines.push([a.to_radians(), b.to_radians(), c.to_radians(), d.to_radians(), value, error]);
            }
            _ => return Err(BrdfCsvError::Line(k + 1)),
        }
    }
    let mut theta_i: Vec<f64> = lines.iter().map(|line| line[0]).collect();
    theta_i.sort_by(f64::total_cmp);
    theta_i.dedup();
    if theta_i.len() != polar {
        return Err(BrdfCsvError::Directions { told: polar, found: theta_i.len() });
    }
    let axes = match azimuths {
        1 => BrdfAxes::isotropic(theta_i.clone(), columns, rows)?,
        _ => BrdfAxes::anisotropic(theta_i.clone(), azimuths, columns, rows)?,
    };
    let cells = axes.cells();
    let (mut share, mut error) = (vec![0.0; axes.slices() * cells], vec![0.0; axes.slices() * cells]);
    let mut table = BrdfTable::new(axes);
    for [theta, phi, theta_o, phi_o, value, spread] in lines {
        let row = theta_i.partition_point(|own| *own < theta);
        let step = std::f64::consts::TAU / azimuths as f64;
        let turn = if azimuths == 1 { 0 } else { ((phi + std::f64::consts::PI) / step).round() as usize % azimuths };
        let slice = row + polar * turn;
        let Some(cell) = table.axes().cell(slice, direction(theta_o, phi_o)) else { continue };
        let projected = f64::from(table.slice_projected(slice)[cell]);
        share[slice * cells + cell] = value * projected;
        error[slice * cells + cell] = spread * projected;
    }
    for slice in 0..table.axes().slices() {
        let of_slice = slice * cells..(slice + 1) * cells;
        table.set_flux(slice, &share[of_slice.clone()], &error[of_slice])?;
    }
    Ok(table)
}

/// Why a text is no BRDF of the program's.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Error)]
#[non_exhaustive]
pub enum BrdfCsvError {
    /// Its grid is not told.
    #[error(
        "this is no brdf.csv: the line that tells its grid is missing; name one that facetmill measure --brdf wrote"
    )]
    NoGrid,
    /// A line that is none.
    #[error("line {0} is not of angles, BRDF and error; measure the plate again")]
    Line(usize),
    /// Some incident directions are missing.
    #[error("{found} polar angles of incidence are there, and {told} were measured; measure the plate again")]
    Directions {
        /// By its head.
        told: usize,
        /// In its lines.
        found: usize,
    },
    /// A grid that cannot be.
    #[error(transparent)]
    Table(#[from] TableError),
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_line_says_what_the_brdf_is_there() {
        let f = |wi: glam::DVec3, wo: glam::DVec3| 0.3 + 0.1 * wi.x * wo.y + 0.05 * wo.z;
        let axes = BrdfAxes::anisotropic(vec![0.0, 0.5, 1.0], 4, 40, 40).unwrap();
        let mut text = Vec::new();
        let table = BrdfTable::from_fn(axes, f);
        write_brdf_csv(&table, &mut text).unwrap();
        let text = String::from_utf8(text).unwrap();
        let back = read_brdf_csv(&text).unwrap();
        for (wi, wo) in [(direction(0.3, 1.0), direction(0.6, -2.0)), (direction(0.9, -1.0), direction(0.2, 0.4))] {
            let (got, wanted) = (back.at(wi, wo), table.at(wi, wo));
            assert!((got - wanted).abs() < 1e-3, "{got} {wanted}");
        }
        let noisy = text.replacen(",3.0", ",-3.0", 1);
        assert!(noisy != text && read_brdf_csv(&noisy).is_ok());
        assert_eq!(read_brdf_csv("a,b\n1,2").unwrap_err(), BrdfCsvError::NoGrid);
        assert!(matches!(read_brdf_csv(&text.replacen("0.0000,", "x,", 1)), Err(BrdfCsvError::Line(_))));
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
