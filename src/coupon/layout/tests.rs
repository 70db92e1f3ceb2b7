use super::*;

fn coupon() -> Coupon {
    Coupon::new(&Machine::preset("vmc").unwrap(), Cutter::ball(0.5), 480.0).unwrap()
}

#[test]
fn lines_lie_where_the_surface_is_what_they_are_for() {
    let coupon = coupon();
    let lines = coupon.lines();
    assert_eq!(lines.len(), 15);
    for (x, place) in lines {
        let rise = |aside: f64| level(x + aside) - level(x - aside);
        let slope = rise(ASIDE) / (2.0 * ASIDE);
        let wanted = match place {
            Place::Up => ramp(),
            Place::Down => -ramp(),
            _ => 0.0,
        };
        assert!((slope - wanted).abs() < 1e-9, "{x}: {slope}");
        let before = level(x - 1.0);
        let hill = if place == Place::AfterHill { 1.0 } else { -1.0 };
        assert!(!matches!(place, Place::AfterHill | Place::AfterValley) || before * hill > 0.01, "{x}: {before}");
        assert_eq!(coupon.place(x + 0.2), Some(place));
    }
    assert_eq!((coupon.place(POLISHED_FROM), coupon.place(-1.0)), (None, None));
}

#[test]
fn a_test_piece_is_kept_as_text_and_wrong_ones_are_refused() {
    let coupon = coupon();
    assert_eq!(Coupon::from_toml(&coupon.to_toml()), Ok(coupon.clone()));
    let other = coupon.to_toml().replace("version = 1", "version = 9");
    assert!(Coupon::from_toml(&other).unwrap_err().to_string().contains("version 9"));
    assert!(Coupon::from_toml("name = 3").is_err());
    let vmc = Machine::preset("vmc").unwrap();
    for cutter in [Cutter::Flat { diameter: 2.0 }, Cutter::ball(0.05)] {
        assert!(matches!(Coupon::new(&vmc, cutter, 480.0), Err(CouponError::Cutter(_))));
    }
    let wild = Machine { track_scatter: 0.1, ..vmc };
    assert!(Coupon::new(&wild, Cutter::ball(0.5), 480.0).unwrap_err().to_string().contains("larger ball"));
}

#[test]
fn passes_follow_each_other_without_gaps() {
    let coupon = coupon();
    let cuts = coupon.cuts();
    assert!(cuts.windows(2).all(|pair| pair[1].0 > pair[0].0 && pair[1].0 - pair[0].0 <= coupon.widest() + 1e-9));
    assert!(cuts[0].0 < 0.0 && cuts[cuts.len() - 1].0 > coupon.size().y);
    assert!(cuts.iter().any(|cut| cut.1));
}
