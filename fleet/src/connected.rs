//! Which recordings have to do with each other: by a courier or a platen that they share, and through others.

use crate::member::Member;

/// A number for each recording, the same for those that are connected.
pub fn groups(members: &[Member]) -> Vec<usize> {
    let mut groups: Vec<usize> = (0..members.len()).collect();
    for (i, member) in members.iter().enumerate() {
        for (j, other) in members[..i].iter().enumerate() {
            let is_shared = member.courier == other.courier || member.platen == other.platen;
            if is_shared && groups[i] != groups[j] {
                let (kept, gone) = (groups[j], groups[i]);
                groups
                    .iter_mut()
                    .filter(|g| **g == gone)
                    .for_each(|g| *g = kept);
            }
        }
    }
    groups
}
