// SPDX-License-Identifier: GPL-2.0-or-later
// The soil in YADE's 3D view.
#pragma once

#include <mutex>
#include <pkg/common/OpenGLRenderer.hpp>

namespace yade {

// Draws what it was shown last, from a copy of its own: the view has a thread of its own, and the soil goes
// on.
class MpmDrawer : public GlExtraDrawer {
  public:
    void render() override;

    // Arrays of float32: corners (n, k, 3) of domains, colours (n, 3). facets: sequence of four corners each;
    // one only where domains are flat. low, high: ends of the colour scale.
    void show(const boost::python::object& corners, const boost::python::object& facets,
              const boost::python::object& colours, double low, double high);

    // clang-format off
    YADE_CLASS_BASE_DOC_ATTRS_CTOR_PY(MpmDrawer, GlExtraDrawer,
        "Draws the domains of the particles of a scene of yade_mpm, coloured by a field; made by "
        ":code:`soil.draw`. Its attributes may be changed at any time, and count at the next look.",
        ((string, label, "mpm", , "Of the scene, as given to :code:`mpm.yade.attach`."))
        ((string, field, "displacement", , "Field that gives the colours; bodies without it are grey."))
        ((string, component, "", , "Of the field: \"x\" of a vector (empty: its length), \"xy\" of a tensor."))
        ((vector<Real>, limits, , , "Values at the two ends of the colour scale; empty: the extremes at each look."))
        ((vector<Real>, shown, , (Attr::readonly | Attr::noSave), "Values at the two ends of the colour scale at the last look."))
        ((int, period, 100, , "Steps between two looks at the soil."))
        ((vector<string>, bodies, , , "Names of the bodies of the scene to be drawn; empty: all."))
        ((string, colours, "viridis", , "Name of a colour map of matplotlib."))
        ((bool, wire, false, , "Draw edges only."))
        ((int, count, 0, (Attr::readonly | Attr::noSave), "Number of domains that are drawn."))
        ,
        /* ctor */
        ,
        .def("_show", &MpmDrawer::show, "Takes what is to be drawn.")
    );
    // clang-format on

  private:
    std::mutex mutex_;
    std::vector<float> corners_, colours_;
    std::vector<int> facets_;
    size_t each_ = 0; // corners of a domain
};
REGISTER_SERIALIZABLE(MpmDrawer);

} // namespace yade
