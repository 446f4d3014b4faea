//! Every fault wrapper around every part: what is wrong is named, what was in force stays, nothing waits for ever.

mod bank;
mod converter;
mod flash;
mod motion;
mod revival;
