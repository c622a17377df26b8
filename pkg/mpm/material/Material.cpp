// SPDX-License-Identifier: GPL-2.0-or-later
// Parameters of any law that vary in space.
#include "mpm/material/Material.hpp"

namespace mpm {

bool Material::mayVary(const Parameter& parameter) const {
    if (parameter.mayVary) return true;
    const bool isNumber = std::holds_alternative<double*>(parameter.target);
    const bool isOfBody = parameter.name == "density" || parameter.name == "softeningLength";
    return isNumber && !isOfBody && isCopied() && !takesWholeBody() && !section();
}

void Material::vary(const std::string& name, bool does) {
    varying_.erase(std::remove(varying_.begin(), varying_.end(), name), varying_.end());
    outside_.erase(std::remove_if(outside_.begin(), outside_.end(), [&](auto& v) { return v.name == name; }),
                   outside_.end());
    if (!does) return;
    varying_.push_back(name);
    for (const Parameter& p : parameters()) {
        if (p.name != name) continue;
        *std::get<double*>(p.target) = notGiven;
        if (!p.mayVary) outside_.push_back({name, p.unit, p.doc, notGiven});
    }
}

std::vector<StateVariable> Material::allStateVariables() const {
    std::vector<StateVariable> all = stateVariables();
    all.insert(all.end(), outside_.begin(), outside_.end());
    return all;
}

std::vector<double*> Material::targetsOutside() {
    std::vector<double*> targets;
    const std::vector<Parameter> all = parameters();
    for (const StateVariable& variable : outside_)
        for (const Parameter& p : all)
            if (p.name == variable.name) targets.push_back(std::get<double*>(p.target));
    return targets;
}

// The values tell which options of the law are on; no particle has them. Some laws compare two parameters, so one value
// after the other is tried for each.
void Material::finishVarying() {
    if (outside_.empty()) return finish();
    const double candidates[] = {1, 0.1, 0.01, 1e-3, 10, 100};
    const int each = int(std::size(candidates)), most = 10000;
    const std::vector<double*> targets = targetsOutside();
    std::vector<Range> ranges;
    for (const StateVariable& variable : outside_)
        for (const Parameter& p : parameters())
            if (p.name == variable.name) ranges.push_back(p.range);
    std::string first;
    for (int trial = 0; trial < most; ++trial) {
        bool isAllowed = true;
        int rest = trial;
        for (size_t k = 0; k < targets.size(); ++k, rest /= each) {
            *targets[k] = candidates[rest % each];
            isAllowed &= ranges[k].contains(*targets[k]);
        }
        if (rest > 0) break; // all have been tried
        if (!isAllowed) continue;
        try {
            return finish();
        } catch (const InputError& error) {
            if (first.empty()) first = error.what();
        }
    }
    throw InputError(first);
}

} // namespace mpm
