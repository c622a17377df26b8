// SPDX-License-Identifier: GPL-2.0-or-later
// Classes enter a registry from their own file, so that adding one names it nowhere else.
#pragma once

#include "mpm/base/require.hpp"

#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

namespace mpm {

template <class Base> class Registry {
  public:
    using Factory = std::function<std::shared_ptr<Base>()>;

    static bool add(const std::string& name, Factory make) { return table().emplace(name, make).second; }

    static std::shared_ptr<Base> make(const std::string& name) {
        auto found = table().find(name);
        require(found != table().end(), "there is no class named '", name, "'");
        return found->second();
    }

    static std::vector<std::string> names() {
        std::vector<std::string> all;
        for (auto& entry : table()) all.push_back(entry.first);
        return all;
    }

  private:
    static std::map<std::string, Factory>& table() {
        static std::map<std::string, Factory> t;
        return t;
    }
};

// One line at the end of a class's file: MPM_REGISTER(Material, LinearElastic)
#define MPM_REGISTER(Base, Class)                                                                            \
    static const bool registered##Class =                                                                    \
        ::mpm::Registry<Base>::add(#Class, [] { return std::make_shared<Class>(); })

} // namespace mpm
