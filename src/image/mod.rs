//! What an image is: its pixels, what each of its channels holds, and what is said about it.

mod channels;

pub use channels::{BACKGROUND_DEPTH, Channel, ChannelKind, Channels};

use std::ops::Range;

use crate::color::ColorSpace;

/// A rectangle of pixels; (0, 0) is the top left of the whole image.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Window {
    /// Leftmost column.
    pub x: u32,
    /// Topmost row.
    pub y: u32,
    /// Columns. Range: at least 1.
    pub width: u32,
    /// Rows. Range: at least 1.
    pub height: u32,
}

/// A rendered image: linear radiance in cd/m², RGB premultiplied by coverage A, in f32.
#[derive(Clone, Debug)]
pub struct Film {
    spec: ImageSpec,
    /// R, G, B, A, row by row from the top of the spec's window.
    pixels: Vec<[f32; 4]>,
    /// The values of the spec's channels, row by row, channel by channel within, pixel by pixel within that, as a
    /// file has them; empty where there are none.
    values: Vec<f32>,
}

/// All that a film is but for its pixels, and all that the head of its file is made of: known
/// before the first pixel is.
#[derive(Clone, Debug)]
pub(crate) struct ImageSpec {
    /// Width and height of the whole image: the EXR's display window.
    pub(crate) resolution: [u32; 2],
    /// The part that is rendered: the EXR's data window, inside the whole image.
    pub(crate) window: Window,
    /// What there is beside R, G, B, A.
    pub(crate) channels: Channels,
    /// What the EXR header says about the image.
    pub(crate) metadata: Metadata,
}

/// Whole rows of a film.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Rows<'f> {
    /// R, G, B, A, row by row.
    pub(crate) pixels: &'f [[f32; 4]],
    /// The values of further channels, row by row, channel by channel within, pixel by pixel within that.
    pub(crate) values: &'f [f32],
}

/// What the EXR header says about the image beside its windows and channels.
#[derive(Clone, Debug, PartialEq)]
pub struct Metadata {
    /// The space of R, G, B: `colorInteropID`.
    pub color_space: ColorSpace,
    /// World to camera space, for column vectors (p' = M p, `[row][column]`); camera space is left-handed, +x right, +y up,
    /// +z along the view.
    pub world_to_camera: [[f64; 4]; 4],
    /// World to normalized device coordinates, for column vectors, before the division by w:
    /// (0, 0) top left of the display window, y down.
    pub world_to_ndc: [[f64; 4]; 4],
    /// `candela:KEY` = value, sorted by key.
    pub provenance: Vec<(String, String)>,
    /// Attributes that are numbers, as name and value.
    pub numbers: Vec<(String, Number)>,
}

/// A number in the header, of a type of OpenEXR's.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Number {
    /// `int`
    Integer(i32),
    /// `float`
    Float(f32),
    /// `v2f`
    Pair([f32; 2]),
}

impl Window {
    /// All of an image.
    pub const fn whole([width, height]: [u32; 2]) -> Self {
        Self {
            x: 0,
            y: 0,
            width,
            height,
        }
    }

    /// How many pixels it has.
    pub const fn count(self) -> u64 {
        self.width as u64 * self.height as u64
    }

    /// Column and row of every pixel, row by row.
    pub fn pixels(self) -> impl Iterator<Item = [u32; 2]> {
        let columns = move || self.x..self.x + self.width;
        (self.y..self.y + self.height).flat_map(move |y| columns().map(move |x| [x, y]))
    }
}

impl ImageSpec {
    /// As [`Film::apart`] parts a film.
    pub(crate) fn apart(
        &self,
        is_apart: impl Fn(&Channel) -> bool,
        are_theirs: impl Fn(&str) -> bool,
    ) -> [Self; 2] {
        let apart = self.apart_with_places(is_apart, are_theirs);
        apart.map(|(spec, _)| spec)
    }

    /// The same, each with the places that its channels have in this one.
    fn apart_with_places(
        &self,
        is_apart: impl Fn(&Channel) -> bool,
        are_theirs: impl Fn(&str) -> bool,
    ) -> [(Self, Vec<usize>); 2] {
        [true, false].map(|which| {
            let list = &self.channels.list;
            let places: Vec<usize> = (0..list.len())
                .filter(|&place| is_apart(&list[place]) == which)
                .collect();
            let attributes = self.channels.attributes.iter();
            // Sums stay where all that they are made of stays.
            let place_of = |old: &usize| places.iter().position(|place| place == old);
            let sums = self.channels.sums.iter();
            let sums = sums.filter_map(|sum| sum.iter().map(place_of).collect());
            let channels = Channels {
                list: places.iter().map(|&place| list[place].clone()).collect(),
                attributes: attributes
                    .filter(|(name, _)| are_theirs(name) == which)
                    .cloned()
                    .collect(),
                sums: sums.collect(),
            };
            let spec = Self {
                channels,
                ..self.clone()
            };
            (spec, places)
        })
    }
}

impl Film {
    /// A film without light or coverage, and 0 in all further channels.
    pub(crate) fn black(spec: ImageSpec) -> Self {
        let Window { width, height, .. } = spec.window;
        let count = width as usize * height as usize;
        Self {
            pixels: vec![[0.0; 4]; count],
            values: vec![0.0; count * spec.channels.list.len()],
            spec,
        }
    }

    /// A film from its pixels, row by row from the top of `window`.
    ///
    /// # Panics
    /// If the pixels are not as many as `window` holds, or `window` is not inside the image.
    pub fn new(
        resolution: [u32; 2],
        window: Window,
        pixels: Vec<[f32; 4]>,
        metadata: Metadata,
    ) -> Self {
        assert_eq!(pixels.len(), window.width as usize * window.height as usize);
        assert!(
            window.x + window.width <= resolution[0] && window.y + window.height <= resolution[1]
        );
        let spec = ImageSpec {
            resolution,
            window,
            channels: Channels::default(),
            metadata,
        };
        Self {
            spec,
            pixels,
            values: Vec::new(),
        }
    }

    /// The film with these channels beside R, G, B, A instead of those that it had. Their values
    /// are row by row from the top of the window, pixel by pixel, channel by channel within.
    ///
    /// # Panics
    /// If the values are not as many as the pixels have channels, or a sum has channels that are not there.
    #[expect(
        clippy::needless_pass_by_value,
        reason = "a film is given what it has from then on"
    )]
    pub fn with_channels(self, channels: Channels, values: Vec<f32>) -> Self {
        let count = channels.list.len();
        assert_eq!(values.len(), self.pixels.len() * count);
        let mut places = channels.sums.iter().flatten();
        assert!(places.all(|&first| first + 3 <= count));
        let spec = ImageSpec {
            channels,
            ..self.spec
        };
        let width = spec.window.width as usize;
        let rows = values.chunks((width * count).max(1));
        let values = rows
            .flat_map(|row| {
                let of_channel = move |channel| row.iter().skip(channel).step_by(count).copied();
                (0..count).flat_map(of_channel)
            })
            .collect();
        Self {
            spec,
            values,
            ..self
        }
    }

    /// The same film in a window that is the whole image: outside of its own nothing is hit, and there is no light.
    pub(crate) fn in_full_window(self) -> Self {
        let Window {
            x,
            y,
            width,
            height,
        } = self.spec.window;
        let whole = Window::whole(self.spec.resolution);
        if self.spec.window == whole {
            return self;
        }
        let channels = self.spec.channels.list.len();
        let mut film = Self::black(ImageSpec {
            window: whole,
            ..self.spec.clone()
        });
        let [x, width, columns] = [x, width, whole.width].map(|side| side as usize);
        for (channel, of_channel) in film.spec.channels.list.iter().enumerate() {
            if of_channel.name == "Z" {
                for row in film.values.chunks_exact_mut(columns * channels) {
                    row[channel * columns..][..columns].fill(BACKGROUND_DEPTH);
                }
            }
        }
        for row in 0..height as usize {
            let (from, to) = (row * width, (row + y as usize) * columns);
            film.pixels[to + x..][..width].copy_from_slice(&self.pixels[from..][..width]);
            for channel in 0..channels {
                let values = &self.values[from * channels + channel * width..][..width];
                film.values[to * channels + channel * columns + x..][..width]
                    .copy_from_slice(values);
            }
        }
        film
    }

    /// Two films with the same R, G, B and A: one with some channels and the attributes about them, one with all others.
    pub(crate) fn apart(
        self,
        is_apart: impl Fn(&Channel) -> bool,
        are_theirs: impl Fn(&str) -> bool,
    ) -> [Self; 2] {
        let width = self.spec.window.width as usize;
        let count = self.spec.channels.list.len();
        self.spec
            .apart_with_places(is_apart, are_theirs)
            .map(|(spec, places)| {
                let rows = self.values.chunks((width * count).max(1));
                let values = rows.flat_map(|row| {
                    places
                        .iter()
                        .flat_map(|place| &row[place * width..][..width])
                });
                Self {
                    pixels: self.pixels.clone(),
                    values: values.copied().collect(),
                    spec,
                }
            })
    }

    /// Width and height of the whole image, of which [`Film::window`] is a part.
    pub fn resolution(&self) -> [u32; 2] {
        self.spec.resolution
    }

    /// The part of the image that this film holds.
    pub fn window(&self) -> Window {
        self.spec.window
    }

    /// R, G, B, A of every pixel of the window, row by row from its top.
    pub fn pixels(&self) -> &[[f32; 4]] {
        &self.pixels
    }

    /// What the film has beside R, G, B, A.
    pub fn channels(&self) -> &Channels {
        &self.spec.channels
    }

    /// The values of [`Film::channels`] of a pixel, by its place in [`Film::pixels`].
    pub fn values(&self, pixel: usize) -> Vec<f32> {
        let width = self.spec.window.width as usize;
        let count = self.spec.channels.list.len();
        let row = &self.values[pixel / width * width * count..];
        let of_channel = |channel| row[channel * width + pixel % width];
        (0..count).map(of_channel).collect()
    }

    /// What the EXR header says about the image.
    pub fn metadata(&self) -> &Metadata {
        &self.spec.metadata
    }

    /// Adds to what the header says of where the image comes from.
    pub(crate) fn add_provenance(&mut self, entries: impl Iterator<Item = (String, String)>) {
        self.spec.metadata.provenance.extend(entries);
    }

    /// Its pixels and the values of its channels, to be filled.
    pub(crate) fn rows_mut(&mut self) -> (&mut [[f32; 4]], &mut [f32]) {
        (&mut self.pixels, &mut self.values)
    }

    /// All that it is but for its pixels.
    pub(crate) fn spec(&self) -> &ImageSpec {
        &self.spec
    }

    /// Some of its rows, counted from the top of its window.
    pub(crate) fn rows(&self, rows: Range<usize>) -> Rows<'_> {
        let width = self.spec.window.width as usize;
        let channels = self.spec.channels.list.len();
        let pixels = rows.start * width..rows.end * width;
        let values = pixels.start * channels..pixels.end * channels;
        Rows {
            pixels: &self.pixels[pixels],
            values: &self.values[values],
        }
    }
}
