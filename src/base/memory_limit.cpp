#include "base/memory_limit.h"

#include <algorithm>
#include <fstream>
#include <string>
#include <sys/resource.h>
#include <unistd.h>

namespace pave {

double memory_limit() {
    double limit = static_cast<double>(sysconf(_SC_PHYS_PAGES)) * static_cast<double>(sysconf(_SC_PAGESIZE));
    rlimit space{};
    if (getrlimit(RLIMIT_AS, &space) == 0 && space.rlim_cur != RLIM_INFINITY) {
        limit = std::min(limit, static_cast<double>(space.rlim_cur));
    }
    // Control groups, version 2: the own one, "0::/PATH", and the root, which inside a container is the container's.
    std::ifstream own("/proc/self/cgroup");
    std::string path;
    for (std::string line; std::getline(own, line);) {
        if (line.rfind("0::", 0) == 0) {
            path = line.substr(3);
        }
    }
    for (const std::string& group : {std::string(), path}) {
        std::ifstream file("/sys/fs/cgroup" + group + "/memory.max");
        double most = 0.0;
        if (file >> most) { // "max" is none
            limit = std::min(limit, most);
        }
    }
    return limit;
}

} // namespace pave
