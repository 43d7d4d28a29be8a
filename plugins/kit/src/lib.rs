//! What plugins share, on top of the contract: command lines, web servers, files, colours. The
//! validator doesn't use it, so that it stays independent.
