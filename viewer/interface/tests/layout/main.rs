//! The layout of the interface at several sizes of the window and scales: no two controls overlap,
//! none is cut, and nothing over the picture lies over a bar, a panel or anything else.

mod behaviour;
mod camera;
mod checks;
mod fixture;
mod panels;
mod states;
mod texts;
