// SPDX-License-Identifier: GPL-2.0-or-later
#include "mpm/base/plugin.hpp"

#include "mpm/base/publicSymbols.hpp"
#include "mpm/base/require.hpp"

#include <dlfcn.h>

namespace mpm {

namespace {

// Why classes of the library that is being loaded were refused.
std::string& refusals() {
    static std::string all;
    return all;
}

} // namespace

void showPublicSymbols() {
    Dl_info self;
    if (dladdr(reinterpret_cast<void*>(&loadPlugin), &self))
        dlopen(self.dli_fname, RTLD_NOW | RTLD_NOLOAD | RTLD_GLOBAL);
}

bool mayRegister(const std::string& name, const char* build, size_t bytesThere, size_t bytesHere) {
    if (build == std::string(MPM_BUILD) && bytesThere == bytesHere) return true;
    refuseClass(message("its class ", name, " was built for [", build, "; ", bytesThere,
                        " bytes], and this is [", MPM_BUILD, "; ", bytesHere,
                        " bytes]; build it again against this version, with the same compiler and -march"));
    return false;
}

void refuseClass(const std::string& why) { refusals() += (refusals().empty() ? "" : "; ") + why; }

void loadPlugin(const std::string& path) {
    showPublicSymbols();
    refusals().clear();
    if (!dlopen(path.c_str(), RTLD_NOW | RTLD_LOCAL))
        throw InputError(message("loadPlugin: '", path, "' cannot be loaded (", dlerror(),
                                 "); give a library that was built against yade_mpm ", MPM_VERSION));
    if (!refusals().empty()) throw InputError(message("loadPlugin: '", path, "': ", refusals()));
}

} // namespace mpm
