//! The check itself is checked: a page that is broken in each of the ways that it looks for.

/// A way to break a page.
pub struct Fault {
    /// Name of the broken page.
    pub name: &'static str,
    /// What is looked for in the page, once.
    from: &'static str,
    /// What is put in its place.
    to: &'static str,
    /// What the probe is to say.
    pub said: &'static str,
}

/// All of them.
pub const FAULTS: &[Fault] = &[
    Fault {
        name: "wide",
        from: "</main>",
        to: "<div style=\"width:3000px\">wide</div></main>",
        said: "overflows",
    },
    Fault {
        name: "cut",
        from: "<table class=\"many\">",
        to: "<table class=\"many\" style=\"width:3000px;display:table\">",
        said: "a table is cut off",
    },
    Fault {
        name: "unlabelled",
        from: "role=\"img\" aria-label=",
        to: "role=\"img\" data-label=",
        said: "no label",
    },
    Fault {
        name: "small",
        from: "</main>",
        to: "<p style=\"font-size:9px\">small</p></main>",
        said: "letters of 9.0 px",
    },
    Fault {
        name: "pale",
        from: "</main>",
        to: "<p style=\"color:#888;background:#777\">pale</p></main>",
        said: "contrast",
    },
    Fault {
        name: "thrown",
        from: "</main>",
        to: "</main><script>throw new Error('thrown')</script>",
        said: "script error",
    },
    Fault {
        name: "asking",
        from: "</main>",
        to: "</main><img src=\"https://example.invalid/picture.png\" alt=\"asked for\">",
        said: "asks for",
    },
    Fault {
        name: "mute",
        from: "dataset.told;",
        to: "dataset.untold;",
        said: "a pointer over a plot is told nothing",
    },
];

impl Fault {
    /// A page with this fault; none where the page has nothing that could be broken so.
    pub fn in_page(&self, page: &str) -> Option<String> {
        page.contains(self.from)
            .then(|| page.replacen(self.from, self.to, 1))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_fault_changes_a_page_or_says_that_it_cannot() {
        let fault = &FAULTS[0];
        assert_eq!(fault.in_page("<p>"), None);
        assert!(fault.in_page("<main></main>").unwrap().contains("3000px"));
    }
}
