//! The first stage of the `g474` board; everything is in the library.
#![no_std]
#![no_main]

use courier_sensor as _;
