//! End-to-end tests of `canvass convert`, of merging, and of the capture quality.

mod command;
mod cuts;
mod formats_page;
mod kept_and_lost;
mod merging;
mod outputs;
mod quality;
mod recording;
mod rows;
