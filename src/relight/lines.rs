//! The new channels of some lines.

use half::f16;

use super::change::Terms;
use super::plan::{Output, Plan, Sum};
use crate::exr::{SampleKind, StoredExr};

/// Room for what rounding leaves of an exact bound.
const ROOM: f64 = 1.001;

/// Half the smallest value of a type: what rounding changes at most where that is more than its relative error.
const HALF_UNDERFLOW: f64 = 2.98e-8; // 2⁻²⁵
const FLOAT_UNDERFLOW: f64 = 7.1e-46; // 2⁻¹⁵⁰

/// Values that their types do not hold well.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(super) struct Counts {
    /// Beyond ± the largest FLOAT.
    pub(super) clamped_to_float: u64,
    /// Beyond ± the largest HALF.
    pub(super) clamped_to_half: u64,
    /// Of layers in HALF: not 0, but below the smallest normal one.
    pub(super) small_in_half: u64,
    /// The largest of their type in the old file, which stands for any larger one.
    pub(super) were_clamped: u64,
}

impl Counts {
    pub(super) fn add(&mut self, more: Self) {
        self.clamped_to_float += more.clamped_to_float;
        self.clamped_to_half += more.clamped_to_half;
        self.small_in_half += more.small_in_half;
        self.were_clamped += more.were_clamped;
    }
}

/// A channel that is stored in lines.
#[derive(Clone, Copy, Debug)]
struct Channel {
    kind: SampleKind,
    /// Bytes of all channels before it, for each pixel.
    start: usize,
    /// How far a value may be from what it was before it was stored: relatively, and at least.
    rounding: Option<f64>,
    underflow: f64,
    /// Whether anything is computed from it.
    is_used: bool,
    /// Whether it is of a layer.
    is_of_layer: bool,
}

/// How lines are stored, and what is computed from them.
pub(super) struct Lines<'p> {
    plan: &'p Plan,
    width: usize,
    channels: Vec<Channel>,
    /// Bytes of a pixel.
    pixel: usize,
    /// Sums that are whole: the new places of the sum and of its parts.
    sums: Vec<(NewChannel, Vec<NewChannel>)>,
}

/// A channel of the new file.
#[derive(Clone, Copy, Debug)]
struct NewChannel {
    kind: SampleKind,
    /// Bytes of all channels before it, for each pixel.
    start: usize,
}

/// What a thread needs for one line after the other.
pub(super) struct Room {
    /// The values of the channels that are used.
    values: Vec<Vec<f64>>,
    sum: Vec<f64>,
    part: Vec<f64>,
    pub(super) counts: Counts,
    /// How far whole sums are off their parts at most, in the numbers of the new file.
    pub(super) residual: f64,
}

/// The largest difference of a sum to the sum of its parts that is more than rounding explains.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Residual {
    pub(super) size: f64,
    pub(super) column: usize,
    pub(super) line: usize,
    /// The place of the sum's channel.
    pub(super) channel: usize,
}

impl Residual {
    /// The larger of two; of equal ones the one that is further up.
    pub(super) fn larger(self, other: Self) -> Self {
        let place = |it: &Self| (it.line, it.channel, it.column);
        let is_other = other.size > self.size
            || other.size == self.size && other.size > 0.0 && place(&other) < place(&self);
        if is_other { other } else { self }
    }
}

impl<'p> Lines<'p> {
    pub(super) fn new(stored: &StoredExr, plan: &'p Plan) -> Self {
        let mut start = 0;
        let mut channels: Vec<Channel> = Vec::new();
        for (place, name) in stored.names().iter().enumerate() {
            let kind = stored.kind(place);
            channels.push(Channel {
                kind,
                start,
                rounding: stored.rounding(place),
                underflow: match kind {
                    SampleKind::Uint => 0.0,
                    SampleKind::Half => HALF_UNDERFLOW,
                    SampleKind::Float => FLOAT_UNDERFLOW,
                },
                is_used: false,
                is_of_layer: name.contains('.'),
            });
            start += kind.bytes();
        }
        for (&place, output) in plan.kept.iter().zip(&plan.outputs) {
            match output {
                Output::Copy => {}
                Output::Linear(terms) => {
                    channels[place].is_used = true;
                    use_terms(&mut channels, terms);
                }
                Output::Sum(sum) => {
                    channels[place].is_used = true;
                    for part in &sum.parts {
                        channels[part.old].is_used = true;
                        use_terms(&mut channels, &part.new);
                    }
                }
            }
        }
        let mut new: Vec<NewChannel> = Vec::new();
        let mut start_of_new = 0;
        for &place in &plan.kept {
            let kind = stored.kind(place);
            new.push(NewChannel {
                kind,
                start: start_of_new,
            });
            start_of_new += kind.bytes();
        }
        let place_of = |old: usize| {
            let place = plan.kept.iter().position(|&kept| kept == old);
            place.map(|place| new[place])
        };
        let sums = plan.outputs.iter().zip(&new);
        let sums = sums.filter_map(|(output, &sum)| match output {
            Output::Sum(parts) if parts.is_complete => {
                let parts = parts.parts.iter().map(|part| place_of(part.old));
                Some((sum, parts.collect::<Option<_>>()?))
            }
            Output::Sum(_) | Output::Copy | Output::Linear(_) => None,
        });
        Self {
            plan,
            width: stored.size()[0] as usize,
            channels,
            pixel: start,
            sums: sums.collect(),
        }
    }

    /// Room for a thread.
    pub(super) fn room(&self) -> Room {
        let line = || vec![0.0; self.width];
        let values = self.channels.iter();
        let values = values.map(|channel| if channel.is_used { line() } else { Vec::new() });
        Room {
            values: values.collect(),
            sum: line(),
            part: line(),
            counts: Counts::default(),
            residual: 0.0,
        }
    }

    /// Bytes of [`Room`].
    pub(super) fn memory(&self) -> u64 {
        let lines = 2 + self
            .channels
            .iter()
            .filter(|channel| channel.is_used)
            .count() as u64;
        let of_channels = (self.channels.len() * size_of::<Vec<f64>>()) as u64;
        lines * self.width as u64 * size_of::<f64>() as u64 + of_channels
    }

    /// Appends what the new file has of some lines of the old one.
    pub(super) fn change(&self, room: &mut Room, old: &[u8], new: &mut Vec<u8>) {
        for line in old.chunks_exact(self.width * self.pixel) {
            let first = new.len();
            self.read(room, line);
            for (&place, output) in self.plan.kept.iter().zip(&self.plan.outputs) {
                match output {
                    Output::Copy => {
                        new.extend_from_slice(self.stored(place, line));
                        continue;
                    }
                    Output::Linear(terms) => combine(terms, &room.values, &mut room.sum),
                    Output::Sum(sum) => self.add_up(place, sum, room),
                }
                let mut counts = store(&room.sum, self.channels[place], new);
                let columns = 0..self.width;
                let were_clamped = columns.filter(|&x| self.is_at_limit(place, &room.values, x));
                counts.were_clamped = were_clamped.count() as u64;
                room.counts.add(counts);
            }
            self.see_residual(room, &new[first..]);
        }
    }

    /// Finds out how far sums of a new line are off their parts.
    fn see_residual(&self, room: &mut Room, line: &[u8]) {
        let stored = |channel: NewChannel| {
            &line[channel.start * self.width..][..channel.kind.bytes() * self.width]
        };
        for (sum, parts) in &self.sums {
            decode(stored(*sum), sum.kind, &mut room.sum);
            for part in parts {
                decode(stored(*part), part.kind, &mut room.part);
                for (rest, part) in room.sum.iter_mut().zip(&room.part) {
                    *rest -= part;
                }
            }
            let rests = room.sum.iter().map(|rest| rest.abs());
            room.residual = rests.fold(room.residual, f64::max);
        }
    }

    /// How far R, G and B are from what `plan` takes for their parts.
    pub(super) fn residual(&self, room: &mut Room, old: &[u8], top: usize) -> Residual {
        let mut worst = Residual::default();
        let lines = old.chunks_exact(self.width * self.pixel);
        for (line, stored) in (top..).zip(lines) {
            self.read(room, stored);
            let sums = self.plan.kept.iter().zip(&self.plan.outputs);
            let sums = sums.filter_map(|(&place, output)| match output {
                Output::Sum(sum) => Some((place, sum)),
                Output::Copy | Output::Linear(_) => None,
            });
            for (channel, sum) in sums {
                for column in 0..self.width {
                    let (rest, bound) = self.rest(channel, sum, &room.values, column);
                    // Programs that add up in f32 round once for each part.
                    let bound = bound * (1 + sum.parts.len()) as f64;
                    // What is no number is no sum either.
                    let size = if rest.is_nan() {
                        f64::INFINITY
                    } else {
                        rest.abs()
                    };
                    if size > bound {
                        worst = worst.larger(Residual {
                            size,
                            column,
                            line,
                            channel,
                        });
                    }
                }
            }
        }
        worst
    }

    fn stored<'l>(&self, place: usize, line: &'l [u8]) -> &'l [u8] {
        let channel = self.channels[place];
        &line[channel.start * self.width..][..channel.kind.bytes() * self.width]
    }

    /// The values of a line.
    fn read(&self, room: &mut Room, line: &[u8]) {
        for (place, channel) in self.channels.iter().enumerate() {
            if !channel.is_used {
                continue;
            }
            decode(
                self.stored(place, line),
                channel.kind,
                &mut room.values[place],
            );
        }
    }

    /// A sum whose parts have changed.
    fn add_up(&self, place: usize, sum: &Sum, room: &mut Room) {
        let Room {
            values,
            sum: total,
            part,
            counts: _,
            residual: _,
        } = room;
        total.fill(0.0);
        for changed in &sum.parts {
            combine(&changed.new, values, part);
            for (total, part) in total.iter_mut().zip(&*part) {
                *total += part;
            }
        }
        for (column, total) in total.iter_mut().enumerate() {
            let (rest, bound) = self.rest(place, sum, values, column);
            let is_rounding = sum.is_complete && rest.abs() <= bound;
            // Where the sum was beyond what the file can hold, the parts are all there is.
            if !is_rounding && rest.is_finite() && !self.is_at_limit(place, values, column) {
                *total += rest;
            }
        }
    }

    /// What is left of a sum beside its parts, and how much of that may be rounding; 0 where compression may have
    /// changed anything.
    fn rest(&self, place: usize, sum: &Sum, values: &[Vec<f64>], column: usize) -> (f64, f64) {
        let bound = |place: usize, value: f64| {
            let channel = self.channels[place];
            channel
                .rounding
                .map(|rounding| value.abs() * rounding + channel.underflow)
        };
        let whole = values[place][column];
        let mut parts = 0.0;
        let mut bounds = bound(place, whole);
        for part in &sum.parts {
            let value = values[part.old][column];
            parts += value;
            bounds = bounds
                .zip(bound(part.old, value))
                .map(|(sum, one)| sum + one);
        }
        // Infinite light is that of an infinite share.
        let rest = if whole == parts { 0.0 } else { whole - parts };
        (rest, bounds.unwrap_or_default() * ROOM)
    }

    /// Whether a value is the largest that its type holds, which stands for any larger one.
    fn is_at_limit(&self, place: usize, values: &[Vec<f64>], column: usize) -> bool {
        let largest = match self.channels[place].kind {
            SampleKind::Half => f16::MAX.to_f64(),
            SampleKind::Float => f32::MAX.into(),
            SampleKind::Uint => f64::INFINITY,
        };
        values[place][column].abs() >= largest
    }
}

/// Reads values of a kind.
fn decode(stored: &[u8], kind: SampleKind, values: &mut [f64]) {
    let (twos, fours) = (stored.as_chunks::<2>().0, stored.as_chunks::<4>().0);
    let values = values.iter_mut();
    match kind {
        SampleKind::Half => values
            .zip(twos)
            .for_each(|(value, &bytes)| *value = f16::from_ne_bytes(bytes).to_f64()),
        SampleKind::Float => values
            .zip(fours)
            .for_each(|(value, &bytes)| *value = f32::from_ne_bytes(bytes).into()),
        SampleKind::Uint => values
            .zip(fours)
            .for_each(|(value, &bytes)| *value = u32::from_ne_bytes(bytes).into()),
    }
}

fn use_terms(channels: &mut [Channel], terms: &Terms) {
    for &(place, _) in terms {
        channels[place].is_used = true;
    }
}

/// Σ w · v over channels. What is multiplied by 0 is not there, be it infinite.
fn combine(terms: &Terms, values: &[Vec<f64>], sum: &mut [f64]) {
    sum.fill(0.0);
    for &(place, weight) in terms {
        if weight == 0.0 {
            continue;
        }
        for (sum, value) in sum.iter_mut().zip(&values[place]) {
            *sum += weight * value;
        }
    }
}

/// Appends values as the file has them: narrowed to f32, as the renderer does, and from there to HALF.
fn store(values: &[f64], channel: Channel, bytes: &mut Vec<u8>) -> Counts {
    let mut counts = Counts::default();
    let mut narrowed = |value: f64| {
        let narrow = value as f32;
        if value.is_finite() && narrow.is_infinite() {
            counts.clamped_to_float += 1;
            return f32::MAX.copysign(narrow);
        }
        narrow
    };
    match channel.kind {
        SampleKind::Float => {
            let values = values.iter();
            bytes.extend(values.flat_map(|&value| narrowed(value).to_ne_bytes()));
        }
        SampleKind::Half => {
            let (mut clamped, mut small) = (0, 0);
            let largest = f16::MAX.to_f32();
            let values = values.iter().map(|&value| {
                let value = narrowed(value);
                let is_small = value != 0.0 && value.abs() < f16::MIN_POSITIVE.to_f32();
                small += u64::from(is_small && channel.is_of_layer);
                if value.is_finite() && value.abs() > largest {
                    clamped += 1;
                    return f16::MAX.copysign(f16::from_f32(value));
                }
                f16::from_f32(value)
            });
            bytes.extend(values.flat_map(f16::to_ne_bytes));
            counts.clamped_to_half = clamped;
            counts.small_in_half = small;
        }
        SampleKind::Uint => {
            // Nothing is computed into such a channel: layers of light have none.
            bytes.extend(
                values
                    .iter()
                    .flat_map(|&value| (value as u32).to_ne_bytes()),
            );
        }
    }
    counts
}
