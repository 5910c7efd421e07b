//! Suns, and luminaires with their IES files: tables of all types and symmetries.

use std::fmt::Write as _;
use std::fs;

use super::{Draft, Random, Vector, along};

impl Draft<'_> {
    /// A sun on the side of a position.
    pub(super) fn sun(&mut self, position: Vector) {
        let direction = match self.random.count(0, 3) {
            // Straight along an axis.
            0 => self.random.choice(&[
                [0.0, -1.0, 0.0],
                [1.0, 0.0, 0.0],
                [0.0, 0.0, -2.0],
                [-1.0, -1.0, 0.0],
            ]),
            _ => along(self.origin, position, -1.0),
        };
        let lux = self.random.log_between(0.1, 10.0);
        let illuminance = match self.random.count(0, 3) {
            0 => format!("{lux:?}"),
            1 => format!("[{lux:?}, {:?}, {:?}]", 0.9 * lux, 0.8 * lux),
            _ if self.palette.has_spectra() => {
                format!("{{ lux = {lux:?}, color = {{ daylight = 5600 }} }}")
            }
            _ => format!("{{ lux = {lux:?}, color = [1.0, 0.9, 0.8] }}"),
        };
        let _ = write!(
            self.text,
            "[lights.l{}.sun]\ndirection = {direction:?}\nilluminance = {illuminance}\n\n",
            self.lights
        );
        self.lights += 1;
    }

    /// A luminaire that hangs in any way.
    pub(super) fn luminaire(&mut self, position: Vector, strength: f64) {
        let file = format!("luminaire-{}-{}.ies", self.seed, self.lights);
        let table = luminaire(&mut self.random);
        fs::write(self.folder.join(&file), table).unwrap();
        let aim = match self.random.count(0, 3) {
            0 => "direction = [0, -1, 0]".to_owned(),
            1 => format!("direction = {:?}", self.random.direction()),
            _ => {
                let target = self.random.point(1.5);
                format!("look_at = {:?}", self.place(target))
            }
        };
        let up = match self.random.count(0, 2) {
            0 => format!("up = {:?}\n", self.random.direction()),
            _ => String::new(),
        };
        let size = match self.random.count(0, 2) {
            0 => format!("scale = {:?}\n", strength / 100.0),
            _ => format!("intensity = {}\n", self.intensity(strength)),
        };
        let _ = write!(
            self.text,
            "[lights.l{}.ies]\nposition = {position:?}\n{aim}\nfile = \"{file}\"\n{up}{size}\n",
            self.lights
        );
        self.lights += 1;
    }
}

/// The text of an IES file, whose largest intensity is about 100 cd.
fn luminaire(random: &mut Random) -> String {
    let (kind, vertical, horizontal): (u8, [f64; 2], Option<[f64; 2]>) = match random.count(0, 10) {
        0 => (1, [0.0, 90.0], None),
        1 => (1, [0.0, 180.0], None),
        2 => (1, [90.0, 180.0], Some([0.0, 180.0])),
        3 => (1, [0.0, 90.0], Some([0.0, 90.0])),
        4 => (1, [0.0, 180.0], Some([0.0, 180.0])),
        5 => (1, [0.0, 90.0], Some([90.0, 270.0])),
        6 => (1, [0.0, 180.0], Some([0.0, 360.0])),
        7 => (2, [-90.0, 90.0], Some([-90.0, 90.0])),
        8 => (2, [-90.0, 90.0], Some([0.0, 90.0])),
        9 => (3, [-90.0, 90.0], Some([-90.0, 90.0])),
        _ => (3, [-60.0, 60.0], Some([0.0, 90.0])),
    };
    let vertical = angles(random, vertical, 2, 12);
    let horizontal = horizontal.map_or(vec![0.0], |ends| angles(random, ends, 1, 6));
    let mut text = format!(
        "IESNA:LM-63-2002\n[TEST] generated\nTILT=NONE\n1 -1 {} {} {} {kind} 2 0 0 0\n1 1 10\n",
        1.0,
        vertical.len(),
        horizontal.len()
    );
    let mut line = |values: &[f64]| {
        for value in values {
            let _ = write!(text, "{value:?} ");
        }
        text.push('\n');
    };
    line(&vertical);
    line(&horizontal);
    let is_closed = horizontal.last() == Some(&360.0);
    let first: Vec<f64> = vertical.iter().map(|_| candela(random)).collect();
    for index in 0..horizontal.len() {
        if index == 0 || is_closed && index == horizontal.len() - 1 {
            line(&first);
        } else {
            let column: Vec<f64> = vertical.iter().map(|_| candela(random)).collect();
            line(&column);
        }
    }
    text
}

/// Some of it is dark.
fn candela(random: &mut Random) -> f64 {
    if random.chance(0.15) {
        0.0
    } else {
        random.between(1.0, 100.0)
    }
}

/// From one end to the other, so many steps of any width.
fn angles(random: &mut Random, [first, last]: [f64; 2], low: u64, high: u64) -> Vec<f64> {
    let steps = random.count(low, high);
    let mut angles: Vec<f64> = (1..steps)
        .map(|_| first + (last - first) * random.between(0.02, 0.98))
        .collect();
    angles.extend([first, last]);
    angles.sort_by(f64::total_cmp);
    // A degree apart at least.
    angles.dedup_by(|b, a| *b - *a < 1.0);
    if angles.last() != Some(&last) {
        angles.pop();
        angles.push(last);
    }
    angles
}
