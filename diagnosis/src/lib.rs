//! Where the simulation and the real sensor part, which effect does it, and how far adding it closes the gap.
