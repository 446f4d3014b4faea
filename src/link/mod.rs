//! What goes over a byte channel to a host or a neighbour: pure, so that the host links the same code.

pub mod framing;
