//! The report of an experiment that is made by hand: as text, and in a browser.

mod browser;
mod page;
mod sample;
mod webdriver;
