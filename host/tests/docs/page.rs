//! A page of Markdown taken apart: its fenced blocks, links, headings and words in code type.

use pulldown_cmark::{CodeBlockKind, CowStr, Event, Options, Parser, Tag, TagEnd};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// A page and what the tests ask of it.
pub struct Page {
    /// Its path from the project's root, with `/` between folders.
    pub name: String,
    /// Its text.
    pub text: String,
    /// Its fenced and indented blocks in order.
    pub blocks: Vec<Block>,
    /// What its links and pictures lead to.
    pub links: Vec<String>,
    /// The anchors of its headings.
    pub anchors: Vec<String>,
    /// Words in code type within the text.
    pub words: Vec<String>,
}

/// A block of code.
pub struct Block {
    /// What stands after the fence: `console`, `sh not-run`; empty for an indented block.
    pub info: String,
    /// Where its lines stand in the page's text.
    pub lines: Range<usize>,
}

impl Page {
    /// Reads a page below `root`.
    pub fn read(root: &Path, path: &Path) -> Self {
        let text = std::fs::read_to_string(path).unwrap();
        let parts: Vec<_> = path.strip_prefix(root).unwrap().iter().collect();
        let name = parts.join("/".as_ref()).into_string().unwrap();
        Self::new(name, text)
    }

    /// Takes `text` apart.
    pub fn new(name: String, text: String) -> Self {
        let mut page = Self {
            name,
            blocks: vec![],
            links: vec![],
            anchors: vec![],
            words: vec![],
            text: String::new(),
        };
        let mut heading: Option<String> = None;
        let mut in_block = false;
        for (event, range) in Parser::new_ext(&text, Options::all()).into_offset_iter() {
            match event {
                Event::Start(Tag::CodeBlock(kind)) => {
                    in_block = true;
                    page.blocks.push(Block {
                        info: info(kind),
                        lines: range.end..range.end,
                    });
                }
                Event::End(TagEnd::CodeBlock) => in_block = false,
                Event::Text(_) if in_block => {
                    let block = page.blocks.last_mut().unwrap();
                    block.lines = block.lines.start.min(range.start)..range.end;
                }
                Event::Start(Tag::Heading { .. }) => heading = Some(String::new()),
                Event::End(TagEnd::Heading(_)) => page.anchors.extend(heading.take().map(anchor)),
                Event::Start(Tag::Link { dest_url, .. } | Tag::Image { dest_url, .. }) => {
                    page.links.push(dest_url.into_string());
                }
                Event::Html(html) | Event::InlineHtml(html) => page.links.extend(sources(&html)),
                Event::Text(words) => heading.iter_mut().for_each(|title| title.push_str(&words)),
                Event::Code(words) => {
                    heading.iter_mut().for_each(|title| title.push_str(&words));
                    page.words.push(words.into_string());
                }
                _ => {}
            }
        }
        page.text = text;
        page
    }

    /// The lines of a block.
    pub fn lines(&self, block: &Block) -> &str {
        &self.text[block.lines.clone()]
    }
}

fn info(kind: CodeBlockKind) -> String {
    match kind {
        CodeBlockKind::Fenced(info) => info.into_string(),
        CodeBlockKind::Indented => String::new(),
    }
}

/// The anchor that a heading gets on a forge: small letters, digits, `-` and `_`; a space becomes `-`.
fn anchor(title: String) -> String {
    let kept = title.chars().filter_map(|letter| match letter {
        ' ' => Some('-'),
        '-' | '_' => Some(letter),
        _ => letter.is_alphanumeric().then_some(letter),
    });
    kept.flat_map(char::to_lowercase).collect()
}

/// What `src="…"`, `srcset="…"` and `href="…"` name in HTML.
fn sources(html: &CowStr) -> Vec<String> {
    let named = |attribute: &str| {
        html.split(attribute)
            .skip(1)
            .filter_map(|rest| rest.split('"').next())
            .map(str::to_owned)
            .collect::<Vec<_>>()
    };
    ["src=\"", "srcset=\"", "href=\""]
        .into_iter()
        .flat_map(named)
        .collect()
}

/// The pages that a reader is led to: those at the root, all of `docs/`, those of `examples/`.
pub fn all(root: &Path) -> Vec<Page> {
    let mut paths = markdown_in(root);
    let mut folders = vec![root.join("docs"), root.join("examples")];
    while let Some(folder) = folders.pop() {
        paths.extend(markdown_in(&folder));
        folders.extend(entries(&folder).into_iter().filter(|path| path.is_dir()));
    }
    paths.sort();
    paths.iter().map(|path| Page::read(root, path)).collect()
}

fn markdown_in(folder: &Path) -> Vec<PathBuf> {
    let is_markdown = |path: &PathBuf| path.extension().is_some_and(|end| end == "md");
    entries(folder).into_iter().filter(is_markdown).collect()
}

/// What lies in a folder; nothing where there is none.
pub fn entries(folder: &Path) -> Vec<PathBuf> {
    let read = std::fs::read_dir(folder).into_iter().flatten();
    read.map(|entry| entry.unwrap().path()).collect()
}
