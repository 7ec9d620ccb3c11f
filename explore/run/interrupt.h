// Ctrl-C and SIGTERM: finish what is being computed, keep it, and leave.
#pragma once

namespace explore::run {

// From now on SIGINT and SIGTERM set a flag. A second one ends the program at once.
void catch_interrupts();
bool interrupted();

// Thrown by what cannot go on because of it.
struct Interrupted {};

} // namespace explore::run
