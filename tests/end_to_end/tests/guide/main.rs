//! What people are told to buy, print and do.

mod buying;
mod guide;
mod materials;
mod print_groups;
mod printers;
mod printing;
mod promises;
