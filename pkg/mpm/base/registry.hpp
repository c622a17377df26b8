// SPDX-License-Identifier: GPL-2.0-or-later
// Classes enter a registry from their own file, so that no other file has to name a new one. The file may be part of the
// solver or of a plugin; all see the solver's registry.
#pragma once

#include "mpm/base/plugin.hpp"
#include "mpm/base/require.hpp"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace mpm {

template <class Base> class MPM_PUBLIC Registry {
  public:
    using Factory = std::function<std::shared_ptr<Base>()>;

    // build, bytes: of the binary that the class is in, see plugin.hpp. Returns whether it was accepted.
    static bool add(const std::string& name, Factory make, const char* build, size_t bytes) {
        if (!mayRegister(name, build, bytes, table().bytesOfBase)) return false;
        if (table().factories.emplace(name, make).second) return true;
        refuseClass("there is a class named " + name + " already");
        return false;
    }

    static std::shared_ptr<Base> make(const std::string& name) {
        const auto& factories = table().factories;
        const auto found = factories.find(name);
        require(found != factories.end(), "there is no class named '", name, "'");
        return found->second();
    }

    static std::vector<std::string> names() {
        std::vector<std::string> all;
        for (auto& entry : table().factories) all.push_back(entry.first);
        return all;
    }

  private:
    struct Table {
        std::map<std::string, Factory> factories;
        size_t bytesOfBase = sizeof(Base);
    };

    // The solver's, also in a plugin: the symbol is public, and the solver was there first.
    [[gnu::noinline]] static Table& table() {
        static Table t;
        return t;
    }
};

// One line at the end of a class's file: MPM_REGISTER(Material, LinearElastic)
#define MPM_REGISTER(Base, Class)                                                                            \
    static const bool registered##Class = ::mpm::Registry<Base>::add(                                        \
        #Class, [] { return std::make_shared<Class>(); }, MPM_BUILD, sizeof(Base))

} // namespace mpm
