//! Nothing but dependencies and their features: a workspace that takes this among its `build-dependencies` builds what runs at compile time
//! with the features that the others build it with, and cargo finds it built.
