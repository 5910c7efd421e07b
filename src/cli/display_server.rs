//! Pictures shown in tev while they are made, by its protocol over TCP (Müller, tev 1.x and 2.x; pbrt-v4 and others
//! speak it too).
//!
//! A packet is its length in bytes as u32, itself included, and an operation as u8, then what the operation takes;
//! numbers are little-endian, texts end in a zero byte.

use std::io::{self, Write};
use std::net::{TcpStream, ToSocketAddrs};
use std::ops::ControlFlow;
use std::sync::{Mutex, PoisonError};
use std::time::Duration;

use candela::image::Window;
use candela::internal::printable;
use candela::render::{RenderedTile, Sink};

use super::Failure;

/// What tev does with a packet.
const CREATE_IMAGE: u8 = 4;
const UPDATE_IMAGE: u8 = 6;

/// A viewer that takes longer has gone.
const PATIENCE: Duration = Duration::from_secs(10);

/// R, G, B, A.
const OWN_CHANNELS: usize = 4;

/// An image in a viewer.
pub(super) struct DisplayServer {
    address: String,
    name: String,
    /// Of its channels, R, G, B, A first.
    channels: Vec<String>,
    /// `None` once the viewer has gone.
    connection: Mutex<Result<TcpStream, io::Error>>,
}

impl DisplayServer {
    /// Connects to HOST:PORT, and makes an image of this name and resolution there.
    pub(super) fn connect(
        address: &str,
        name: &str,
        [width, height]: [u32; 2],
        channels: Vec<String>,
    ) -> Result<Self, Failure> {
        let trouble = |error: io::Error| {
            Failure::from(format!(
                "no viewer takes pictures at {}: {error}; start tev there first, which listens at \
                 127.0.0.1:14158",
                printable(address)
            ))
        };
        let mut places = address.to_socket_addrs().map_err(trouble)?;
        let place = places.next().ok_or_else(|| {
            trouble(io::Error::new(
                io::ErrorKind::NotFound,
                "the name has no address",
            ))
        })?;
        let mut connection = TcpStream::connect_timeout(&place, PATIENCE).map_err(trouble)?;
        connection
            .set_write_timeout(Some(PATIENCE))
            .map_err(trouble)?;
        let mut packet = Packet::new(CREATE_IMAGE);
        packet.boolean(true).text(name);
        for number in [width, height, channels.len() as u32] {
            packet.number(number);
        }
        for channel in &channels {
            packet.text(channel);
        }
        packet.send(&mut connection).map_err(trouble)?;
        Ok(Self {
            address: address.to_owned(),
            name: name.to_owned(),
            channels,
            connection: Mutex::new(Ok(connection)),
        })
    }

    /// Shows the values of a window, pixel by pixel, channel by channel within.
    pub(super) fn update(&self, window: Window, values: impl Iterator<Item = f32>) {
        let mut connection = self
            .connection
            .lock()
            .unwrap_or_else(PoisonError::into_inner);
        let Ok(stream) = connection.as_mut() else {
            return;
        };
        let count = self.channels.len() as u64;
        let mut packet = Packet::new(UPDATE_IMAGE);
        packet.boolean(false).text(&self.name);
        packet.number(count as u32);
        for channel in &self.channels {
            packet.text(channel);
        }
        for number in [window.x, window.y, window.width, window.height] {
            packet.number(number);
        }
        for offset in 0..count {
            packet.long(offset);
        }
        for _ in 0..count {
            packet.long(count);
        }
        for value in values {
            packet.bytes.extend_from_slice(&value.to_le_bytes());
        }
        if let Err(error) = packet.send(stream) {
            *connection = Err(error);
        }
    }

    /// What there is to say at the end, if the viewer has gone.
    pub(super) fn warning(self) -> Option<String> {
        let connection = self.connection.into_inner();
        let error = connection.unwrap_or_else(PoisonError::into_inner).err()?;
        Some(format!(
            "the viewer at {} has not seen all of the picture: {error}",
            printable(&self.address)
        ))
    }
}

impl Sink for DisplayServer {
    fn take(&self, tile: &RenderedTile) -> ControlFlow<()> {
        let further = self.channels.len() - OWN_CHANNELS;
        let count = tile.pixels().len();
        let values = tile.pixels().iter().enumerate().flat_map(|(place, pixel)| {
            let further = tile
                .values()
                .iter()
                .skip(place)
                .step_by(count)
                .take(further);
            pixel.iter().chain(further).copied()
        });
        self.update(tile.window(), values);
        ControlFlow::Continue(())
    }
}

/// A packet that is being written.
struct Packet {
    bytes: Vec<u8>,
}

impl Packet {
    fn new(operation: u8) -> Self {
        Self {
            bytes: vec![0, 0, 0, 0, operation],
        }
    }

    fn boolean(&mut self, value: bool) -> &mut Self {
        self.bytes.push(u8::from(value));
        self
    }

    fn text(&mut self, text: &str) -> &mut Self {
        // A zero byte would end it.
        self.bytes.extend(text.bytes().filter(|&byte| byte != 0));
        self.bytes.push(0);
        self
    }

    fn number(&mut self, number: u32) -> &mut Self {
        self.bytes.extend_from_slice(&number.to_le_bytes());
        self
    }

    fn long(&mut self, number: u64) -> &mut Self {
        self.bytes.extend_from_slice(&number.to_le_bytes());
        self
    }

    fn send(mut self, connection: &mut TcpStream) -> io::Result<()> {
        let length = u32::try_from(self.bytes.len())
            .map_err(|_| io::Error::new(io::ErrorKind::InvalidInput, "too much at a time"))?;
        self.bytes[..4].copy_from_slice(&length.to_le_bytes());
        connection.write_all(&self.bytes)
    }
}

#[cfg(test)]
mod tests {
    use std::io::Read;
    use std::net::TcpListener;
    use std::thread;

    use super::*;

    /// Bytes as the protocol has them, written out by hand.
    #[test]
    fn packets() {
        let listener = TcpListener::bind("127.0.0.1:0").unwrap();
        let address = listener.local_addr().unwrap().to_string();
        let viewer = thread::spawn(move || {
            let mut bytes = Vec::new();
            listener
                .accept()
                .unwrap()
                .0
                .read_to_end(&mut bytes)
                .unwrap();
            bytes
        });
        let channels = ["R", "key.R"].map(str::to_owned).to_vec();
        let server = DisplayServer::connect(&address, "a", [3, 2], channels).unwrap();
        let window = Window {
            x: 1,
            y: 0,
            width: 1,
            height: 1,
        };
        server.update(window, [0.5, 2.0].into_iter());
        assert_eq!(server.warning(), None);
        let mut expected = vec![
            28, 0, 0, 0, 4, 1, b'a', 0, 3, 0, 0, 0, 2, 0, 0, 0, 2, 0, 0, 0,
        ];
        expected.extend_from_slice(b"R\0key.R\0");
        let first = expected.len();
        expected.extend_from_slice(&[0, 0, 0, 0, 6, 0, b'a', 0, 2, 0, 0, 0]);
        expected.extend_from_slice(b"R\0key.R\0");
        for number in [1_u32, 0, 1, 1] {
            expected.extend_from_slice(&number.to_le_bytes());
        }
        for number in [0_u64, 1, 2, 2] {
            expected.extend_from_slice(&number.to_le_bytes());
        }
        expected.extend_from_slice(&[0, 0, 0, 0x3f, 0, 0, 0, 0x40]);
        let length = (expected.len() - first) as u8;
        expected[first] = length;
        assert_eq!(viewer.join().unwrap(), expected);
    }

    #[test]
    fn nobody_there() {
        // A port that was free a moment ago.
        let port = {
            let listener = TcpListener::bind("127.0.0.1:0").unwrap();
            listener.local_addr().unwrap().port()
        };
        let address = format!("127.0.0.1:{port}");
        let error = DisplayServer::connect(&address, "a", [1, 1], Vec::new());
        let error = error.err().unwrap().to_string();
        assert!(
            error.starts_with(&format!("no viewer takes pictures at {address}: ")),
            "{error}"
        );
        assert!(DisplayServer::connect("nowhere", "a", [1, 1], Vec::new()).is_err());
    }
}
