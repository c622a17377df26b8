// SPDX-License-Identifier: GPL-2.0-or-later
// What Python keeps for a thread of a host.
//
// YADE takes Python's lock for every command of a PyRunner. In a thread that Python has not started this
// makes a thread state each time and throws it away behind the command, which costs several times what the
// command does. A count more keeps the state until the thread ends.
#include "python.hpp"

#include <sys/syscall.h>
#include <unistd.h>

namespace mpm::python {

namespace {

bool isFinalizing() {
#if PY_VERSION_HEX >= 0x030D0000
    return Py_IsFinalizing();
#else
    return _Py_IsFinalizing();
#endif
}

class KeptState {
  public:
    KeptState() { PyGILState_Ensure(); }
    ~KeptState() {
        if (!Py_IsInitialized() || isFinalizing()) return; // there is none left
        const PyGILState_STATE before = PyGILState_Ensure();
        PyGILState_Release(PyGILState_LOCKED); // the count more
        PyGILState_Release(before);
    }
};

// For the calling thread, which holds the lock; the main thread keeps its state anyway.
void keepThreadState() {
    if (syscall(SYS_gettid) == getpid()) return;
    thread_local const KeptState kept;
    static_cast<void>(kept);
}

} // namespace

void exposeThreadState() { bp::def("keepThreadState", keepThreadState); }

} // namespace mpm::python
