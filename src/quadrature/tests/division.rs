//! Pixels that are integrated in parts.

use super::*;

/// Of pixels that are not told, as edges cross or end in them, parts tell nearly all to the target; and what they say holds of the
/// means over 4096 samples, which are off by up to 4e-3 of what is around.
#[test]
fn where_edges_cross_parts_tell_the_mean() {
    with_scene("shadows", |world, camera, visibility| {
        let [width, height] = RESOLUTION;
        let window = Window {
            x: 0,
            y: 0,
            width,
            height,
        };
        let options = Options {
            samples: 4096,
            ..Options::default()
        };
        let renderer = Renderer::new(world).unwrap();
        let many = renderer.film(camera, &options, &Job::new()).unwrap().0;
        let level = SimdLevel::default();
        let mut quadrature = Quadrature::new(world, camera, visibility, level, TARGET, true);
        let mut verdicts = Vec::new();
        quadrature.tell(window, &mut verdicts);
        let (mut open, mut met) = (0, 0);
        for (place, verdict) in verdicts.iter().enumerate() {
            if !matches!(verdict, Verdict::Open { range: Some(_), .. }) {
                continue;
            }
            open += 1;
            let [x, y] = [place as u32 % width, place as u32 / width];
            let Some(mean) = quadrature.divide([x, y], 1024) else {
                continue;
            };
            met += u32::from(TARGET.is_met(mean.value, mean.error));
            assert!(mean.is_bound, "[{x}, {y}]: {mean:?}");
            let around = |place: u32, size: u32| place.saturating_sub(1)..(place + 2).min(size);
            for channel in 0..4 {
                let near = around(y, height).flat_map(|y| around(x, width).map(move |x| [x, y]));
                let brightest = near
                    .map(|[x, y]| f64::from(many.pixels()[(y * width + x) as usize][channel]))
                    .fold(0.0, f64::max);
                let off = (mean.value[channel] - f64::from(many.pixels()[place][channel])).abs();
                assert!(
                    off <= mean.error[channel] + 4e-3 * brightest,
                    "[{x}, {y}]: {off:e} off; {mean:?}, {:?}",
                    many.pixels()[place]
                );
            }
        }
        println!("{met} of {open}");
        assert!(
            open > 20 && f64::from(met) > 0.9 * f64::from(open),
            "{met} of {open}"
        );
    });
}
