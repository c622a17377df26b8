// SPDX-License-Identifier: GPL-2.0-or-later
#include "yade/MpmDrawer.hpp"

#include <GL/gl.h>

namespace yade {

namespace {

namespace py = boost::python;

using Corner = Eigen::Map<const Eigen::Vector3f>;

// An array of Python as long as this lives.
class Floats {
  public:
    Floats(const py::object& array, const char* name, int dim) {
        if (PyObject_GetBuffer(array.ptr(), &view_, PyBUF_C_CONTIGUOUS | PyBUF_FORMAT) != 0)
            py::throw_error_already_set();
        if (std::string(view_.format) == "f" && view_.ndim == dim && view_.shape[dim - 1] == 3) return;
        PyBuffer_Release(&view_);
        throw std::invalid_argument(std::string("MpmDrawer: ") + name + " is no array of float32 (n, " +
                                    (dim == 3 ? "k, 3)" : "3)"));
    }
    ~Floats() { PyBuffer_Release(&view_); }
    Floats(const Floats&) = delete;
    Floats& operator=(const Floats&) = delete;

    size_t size(int axis) const { return size_t(view_.shape[axis]); }
    std::vector<float> copy() const {
        const auto* first = static_cast<const float*>(view_.buf);
        return {first, first + view_.len / Py_ssize_t(sizeof(float))};
    }

  private:
    Py_buffer view_;
};

} // namespace

void MpmDrawer::show(const py::object& corners, const py::object& facets, const py::object& colours,
                     double low, double high) {
    const Floats at(corners, "corners", 3), colour(colours, "colours", 2);
    if (at.size(0) != colour.size(0))
        throw std::invalid_argument("MpmDrawer: there are not as many colours as domains");
    std::vector<int> numbers;
    for (long f = 0; f < py::len(facets); ++f)
        for (int k = 0; k < 4; ++k) {
            numbers.push_back(py::extract<int>(facets[f][k]));
            if (numbers.back() < 0 || size_t(numbers.back()) >= at.size(1))
                throw std::invalid_argument("MpmDrawer: a facet has a corner that no domain has");
        }
    const std::lock_guard<std::mutex> lock(mutex_);
    corners_ = at.copy();
    colours_ = colour.copy();
    facets_ = std::move(numbers);
    each_ = at.size(1);
    count = int(at.size(0));
    shown = {low, high};
}

void MpmDrawer::render() {
    const std::lock_guard<std::mutex> lock(mutex_);
    glPushAttrib(GL_ENABLE_BIT | GL_POLYGON_BIT | GL_LIGHTING_BIT | GL_CURRENT_BIT);
    glDisable(GL_CULL_FACE);
    if (wire || facets_.size() == 4) // of flat domains light would only change the colours
        glDisable(GL_LIGHTING);
    glPolygonMode(GL_FRONT_AND_BACK, wire ? GL_LINE : GL_FILL);
    glBegin(GL_QUADS);
    for (size_t p = 0; p < colours_.size() / 3; ++p) {
        const float* domain = &corners_[3 * each_ * p];
        glColor3fv(&colours_[3 * p]);
        for (size_t f = 0; f < facets_.size(); f += 4) {
            const auto corner = [&](int k) { return domain + 3 * facets_[f + k]; };
            const Eigen::Vector3f normal = (Corner(corner(2)) - Corner(corner(0)))
                                               .cross(Corner(corner(3)) - Corner(corner(1)))
                                               .normalized();
            glNormal3fv(normal.data());
            for (int k = 0; k < 4; ++k) glVertex3fv(corner(k));
        }
    }
    glEnd();
    glPopAttrib();
}

YADE_PLUGIN((MpmDrawer));

} // namespace yade
