// Ctrl-C, SIGTERM and a terminal that is closed: finish what is being computed, keep it, and leave.
#pragma once

namespace explore::run {

// From now on SIGINT, SIGTERM and (unless it is ignored, as under nohup) SIGHUP set a flag and say that what is running
// is awaited; after the latter two for five seconds at most. A second one ends the program at once.
void catch_interrupts();
// For a command that keeps nothing: they end the program at once, with exit status 130 and a word.
void end_at_interrupts();
bool interrupted();

// For a program that catches signals itself: what is running ends as after one, until it is forgotten.
void request_interrupt();
void forget_interrupt();

// Thrown by what cannot go on because of it.
struct Interrupted {};

} // namespace explore::run
