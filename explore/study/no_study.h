// Text that is no study, told before or after it is read as one. Private to study/.
#pragma once

#include <string>

namespace explore::study {

// toml++ goes down a key such as a.b.c one call a part. Throws pave::Error for a line of too many.
void refuse_deep_keys(const std::string& text, const std::string& file);

// Where text that is no study holds readings: throws pave::Error that says which command takes it.
void refuse_readings(const std::string& text, const std::string& file);

} // namespace explore::study
