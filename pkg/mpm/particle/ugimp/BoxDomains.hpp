// SPDX-License-Identifier: GPL-2.0-or-later
// The domains of a uGIMP body: boxes that are re-sorted when neighbours in memory have drifted apart, cut in
// two when they are too long, and that may carry the outline of the region they were cut from.
#pragma once

#include "mpm/particle/ugimp/BoxTransfers.hpp"
#include "mpm/particle/ugimp/Splitting.hpp"

namespace mpm {

template <int Dim> class BoxDomains : public BoxTransfers<Dim>, public CutBoxes<Dim> {
  public:
    using Base = BoxTransfers<Dim>;
    using Base::particles, Base::grid, Base::order;

    BoxDomains(Particles<Dim>& particles, const Grid<Dim>& grid, double splitAt, bool hasOutline)
        : Base(particles, grid), splitting_(splitAt), hasOutline_(hasOutline) {}

    void build(const Geometry<Dim>& geometry) override {
        constexpr double roundOff = 1e-12; // of a spacing that was computed as a part of a cell
        for (int k = 0; k < Dim; ++k)
            require(geometry.halfSize[k] > 0 &&
                        geometry.halfSize[k] <= 0.5 * grid.smallestCell()[k] * (1 + roundOff),
                    "UGIMP in '", Base::bodyName, "': half size ", geometry.halfSize[k],
                    " m must be positive and at most half a cell (", 0.5 * grid.smallestCell()[k],
                    " m); use more particles per cell");
        if (splitting_.isOn()) splitting_.start(int(geometry.positions.size()));
        outline_.set(geometry.carriers, geometry.offsets, geometry.areas);
        Base::build(geometry);
    }

    std::vector<Field*> fields() override {
        std::vector<Field*> all = Base::fields();
        if (splitting_.isOn()) all.push_back(&splitting_.share);
        if (hasOutline_)
            for (Field* field : outline_.fields()) all.push_back(field);
        return all;
    }
    std::vector<std::pair<std::string, std::vector<int>*>> tables() override {
        auto all = Base::tables();
        all.emplace_back("runsWhenSorted", &runsWhenSorted_);
        return all;
    }

    void restored() override {
        outline_.find(particles);
        Base::restored();
    }

    bool resort() override {
        if (Base::isSorted_) runsWhenSorted_[0] = order.runs();
        Base::resort();
        if (splitting_.isOn()) splitting_.expect(particles.size());
        return Base::isSorted_;
    }

    void volumes(int begin, int end) override {
        Base::volumes(begin, end);
        if (splitting_.isOn()) splitting_.look(particles, begin, end);
    }

    bool splitStretched() override {
        if (!splitting_.isOn() || !splitting_.cut(particles, Base::halfSize(), outline_)) return false;
        Base::grown();
        return true;
    }
    const std::vector<CutBox<Dim>>& justCut() const override { return splitting_.justCut(); }
    const Outline<Dim>* outline() const override { return outline_.size() > 0 ? &outline_ : nullptr; }

  protected:
    // Each run reads and writes all nodes of its support, so short runs make a step slow; to sort takes about
    // as long as a step.
    bool isScattered() const override {
        constexpr int mostGrowth = 2;   // of the number of runs, since the last sorting
        constexpr int runsToSpare = 64; // for small bodies, which would be sorted again and again
        return order.runs() > mostGrowth * runsWhenSorted_[0] + runsToSpare;
    }

    void permuted(const std::vector<int>& numbers) override {
        splitting_.permute(numbers);
        outline_.find(particles);
    }

  private:
    Splitting<Dim> splitting_;
    Outline<Dim> outline_;
    const bool hasOutline_;
    std::vector<int> runsWhenSorted_{0};
};

} // namespace mpm
