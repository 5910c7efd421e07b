//! The command line.

#[cfg(test)]
mod cli;

fn main() {}
