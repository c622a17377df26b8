// SPDX-License-Identifier: GPL-2.0-or-later
// A law in Fortran or C with the call of Abaqus' UMAT, from a shared library.
#include "mpm/base/publicSymbols.hpp"
#include "mpm/material/OutsideLaw.hpp"
#include "mpm/material/required.hpp"

#include <csetjmp>
#include <cstdlib>
#include <cstring>

namespace {

// Where STOP and XIT go on while a UMAT runs in this thread.
struct Stop {
    std::jmp_buf back;
    char said[200] = "";
};
thread_local Stop* running = nullptr;

void stopHere(const char* what, const char* text, size_t length) {
    if (!running) { // of another library
        std::fprintf(stderr, "%s %.*s\n", what, int(length), text ? text : "");
        std::exit(1);
    }
    std::snprintf(running->said, sizeof running->said, "stops by %s%s%.*s", what, length > 0 ? ": " : "",
                  int(std::min(length, size_t(150))), text ? text : "");
    std::longjmp(running->back, 1); // over frames of Fortran, which have nothing to clean up
}

void stopWithNumber(const char* what, int code) {
    char text[16];
    std::snprintf(text, sizeof text, "%d", code);
    stopHere(what, text, std::strlen(text));
}

} // namespace

// What gfortran makes of STOP and ERROR STOP, and Abaqus' way to end a run: libraries that are loaded later find these
// before those of Fortran, so that the message can name the particle.
extern "C" {
MPM_PUBLIC void _gfortran_stop_string(const char* text, size_t length, bool) {
    stopHere("STOP", text, length);
}
MPM_PUBLIC void _gfortran_stop_numeric(int code, bool) { stopWithNumber("STOP", code); }
MPM_PUBLIC void _gfortran_error_stop_string(const char* text, size_t length, bool) {
    stopHere("ERROR STOP", text, length);
}
MPM_PUBLIC void _gfortran_error_stop_numeric(int code, bool) { stopWithNumber("ERROR STOP", code); }
MPM_PUBLIC void xit_() { stopHere("XIT", "", 0); }
}

namespace mpm {
namespace {

using Umat = void (*)(double* stress, double* statev, double* ddsdde, double* sse, double* spd, double* scd,
                      double* rpl, double* ddsddt, double* drplde, double* drpldt, const double* stran,
                      const double* dstran, const double* time, const double* dtime, const double* temp,
                      const double* dtemp, const double* predef, const double* dpred, const char* cmname,
                      const int* ndi, const int* nshr, const int* ntens, const int* nstatv,
                      const double* props, const int* nprops, const double* coords, const double* drot,
                      double* pnewdt, const double* celent, const double* dfgrd0, const double* dfgrd1,
                      const int* noel, const int* npt, const int* layer, const int* kspt, const int* kstep,
                      const int* kinc, size_t cmnameLength);

class UMAT : public OutsideLaw {
  public:
    std::string className() const override { return "UMAT"; }
    std::string doc() const override {
        return R"(A law in Fortran or C with Abaqus' call UMAT, from a shared library.

    sand = mpm.UMAT("libsand.so", density=1.6, properties=[...], states=[...])

NTENS is 6 in all dimensions, the order 11 22 33 12 13 23, with engineering shear. The solver turns STRESS and STRAN to
the axes at the end of the step before the call and gives DROT for tensors among the states; DSTRAN is that of the
midpoint (Hughes & Winget). The critical step and hourglass control use DDSDDE, the largest of a particle so far: set it
in every call. NaN, STOP, XIT and PNEWDT < 1 end the run with a message that names the particle. CELENT is 1, TEMP 0.

Source: Abaqus User Subroutines Reference Guide, UMAT; Hughes & Winget 1980, Int. J. Numer. Methods Eng. 15, 1862-1867.)";
    }
    std::vector<Parameter> parameters() override {
        std::vector<Parameter> all{
            {"library", "", "required: path of the shared library", &library_},
            {"density", "Mg/m3", "required: mass density, initial", &density, Range::positive()}};
        for (auto& parameter : commonParameters()) all.push_back(parameter);
        all.push_back({"routine", "", "symbol of the routine; gfortran writes it small, with an underscore",
                       &routine_});
        all.push_back({"name", "", "CMNAME, for libraries with several laws", &name_});
        return all;
    }
    void finish() override {
        require(!library_.empty(), "UMAT: library is required; give the path of a shared library");
        requireDensity("UMAT", density);
        require(name_.size() <= sizeof cmname_, "UMAT: name = '", name_, "' is longer than 80 characters");
        showPublicSymbols();
        umat_ = reinterpret_cast<Umat>(symbol(routine_));
        std::fill_n(cmname_, sizeof cmname_, ' ');
        std::copy(name_.begin(), name_.end(), cmname_);
        findInitialStiffness();
    }

  protected:
    std::vector<std::string> stateNames() const override {
        std::vector<std::string> all;
        for (size_t k = 1; k <= states_.size(); ++k) all.push_back("statev" + std::to_string(k));
        return all;
    }

    void call(OutsideCall& p) const override {
        double ddsdde[36] = {}, spd = 0, scd = 0, rpl = 0, ddsddt[6] = {}, drplde[6] = {}, drpldt = 0,
               newStep = 1;
        double rotation[9], F0[9], F1[9];
        transpose(p.rotation, rotation);
        transpose(p.F0, F0);
        transpose(p.F1, F1);
        const double time[] = {p.time, p.time}, none = 0, length = 1;
        const int three = 3, six = 6, one = 1, states = int(states_.size()),
                  properties = int(properties_.size());
        const int step[] = {1, 0, 0, 0}, increment = int(std::min<int64_t>(p.step + 1, 2147483647)),
                  id = int(p.id);
        Stop stop;
        running = &stop;
        if (setjmp(stop.back) == 0)
            umat_(p.stress, p.states, ddsdde, &p.stored, &spd, &scd, &rpl, ddsddt, drplde, &drpldt, p.strain,
                  p.increment, time, &p.dt, &none, &none, &none, &none, cmname_, &three, &three, &six,
                  &states, properties_.data(), &properties, p.position, rotation, &newStep, &length, F0, F1,
                  &id, &one, &one, &one, step, &increment, sizeof cmname_);
        running = nullptr;
        if (*stop.said) throw RunError(stop.said);
        if (newStep < 1) throw RunError(message("asks for a step of ", newStep, " of dt (PNEWDT)"));
        transpose6(ddsdde, p.tangent);
    }

  private:
    std::string routine_ = "umat_", name_ = "";
    char cmname_[80] = {};
    Umat umat_ = nullptr;

    // Fortran counts columns first.
    static void transpose(const double* rows, double* columns) {
        for (int c = 0; c < 9; ++c) columns[c] = rows[3 * (c % 3) + c / 3];
    }
    static void transpose6(const double* columns, double* rows) {
        for (int c = 0; c < 36; ++c) rows[c] = columns[6 * (c % 6) + c / 6];
    }
};

MPM_REGISTER(Material, UMAT);

} // namespace
} // namespace mpm
