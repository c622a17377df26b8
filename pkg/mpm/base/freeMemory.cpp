// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/base/freeMemory.hpp"

#include <algorithm>
#include <fstream>
#include <limits>

#ifdef __linux__
#include <sys/resource.h>
#include <unistd.h>
#endif

namespace mpm {

namespace {

constexpr double unlimited = std::numeric_limits<double>::infinity();

// The number behind a name in a file of such lines; `otherwise` if there is none.
double entry(const std::string& path, const std::string& name, double otherwise) {
    std::ifstream file(path);
    std::string first;
    for (double number; file >> first >> number; std::getline(file, first))
        if (first == name) return number;
    return otherwise;
}

// The number that a file begins with; no limit if it says "max", or is not there.
double number(const std::string& path) {
    double found;
    return std::ifstream(path) >> found ? found : unlimited;
}

// How the two versions of control groups name their files.
struct Names {
    const char *folder, *limit, *used, *reclaimable;
};
constexpr Names first{"/sys/fs/cgroup/memory", "/memory.limit_in_bytes", "/memory.usage_in_bytes",
                      "total_inactive_file"};
constexpr Names second{"/sys/fs/cgroup", "/memory.max", "/memory.current", "inactive_file"};

// What a group and those around it leave.
double leftInGroups(const std::string& root, const Names& names, std::string group) {
    double left = unlimited;
    while (true) {
        const std::string folder = root + names.folder + group;
        const double limit = number(folder + names.limit);
        if (limit < unlimited)
            left = std::min(left, limit - number(folder + names.used) +
                                      entry(folder + "/memory.stat", names.reclaimable, 0));
        if (group.empty()) return left;
        group.erase(group.rfind('/'));
    }
}

// Lines are NUMBER:CONTROLLERS:/GROUP, without controllers in the second version. In a container the group
// may be named as outside, where no folder is; then those around it count.
double leftInGroups(const std::string& root) {
    std::ifstream file(root + "/proc/self/cgroup");
    double left = unlimited;
    for (std::string line; std::getline(file, line);) {
        const size_t one = line.find(':'), two = line.find(':', one + 1);
        if (two == std::string::npos || line.compare(two, 2, ":/") != 0) continue;
        const std::string controllers = line.substr(one + 1, two - one - 1), group = line.substr(two + 1);
        if (controllers.empty()) left = std::min(left, leftInGroups(root, second, group));
        if (controllers == "memory") left = std::min(left, leftInGroups(root, first, group));
    }
    return left;
}

double leftOfAddresses([[maybe_unused]] const std::string& root) {
#ifdef __linux__
    rlimit limit;
    if (getrlimit(RLIMIT_AS, &limit) == 0 && limit.rlim_cur != RLIM_INFINITY)
        return limit.rlim_cur - number(root + "/proc/self/statm") * sysconf(_SC_PAGESIZE);
#endif
    return unlimited;
}

} // namespace

double freeMemory(const std::string& root) {
    const std::string system = root + "/proc/meminfo";
    const double ofSystem =
        1024 * (entry(system, "MemAvailable:", unlimited) + entry(system, "SwapFree:", 0));
    return std::max(0.0, std::min({ofSystem, leftInGroups(root), leftOfAddresses(root)}));
}

} // namespace mpm
