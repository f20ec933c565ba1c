#pragma once

#include <functional>
#include <thread>

namespace tumble {

/// A thread that no signal interrupts: signals are for the one who looks at the rig.
std::thread quiet_thread(std::function<void()> work);

}  // namespace tumble
