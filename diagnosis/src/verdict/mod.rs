//! What is answered: the data of an answer, the evidence behind it, and whether another recording confirms it.

pub mod answer;
pub mod confirmation;
pub mod evidence;
pub mod odds;
