// Lines on standard error. That nobody can read them is no reason to stop, so they never throw.
#pragma once

#include <cstdio>
#include <fmt/format.h>
#include <utility>

namespace explore::run {

template <class... Values>
void message(fmt::format_string<Values...> format, Values&&... values) {
    std::fputs(fmt::format(format, std::forward<Values>(values)...).c_str(), stderr);
}

} // namespace explore::run
