#pragma once

#include <functional>
#include <memory>
#include <string>

#include "terminal.hpp"

/// Output of a process that looks after a rig or a stream. A terminal may take nothing for a while (Ctrl+S, a stalled
/// connection), and a log may lie on a disk that hangs: who speaks puts the text into a queue with a bound, and a
/// thread of its own writes it. So no look at the rig ever waits for output.
namespace tumble::cli {

/// From now on print(), notes, complaints and blocks go into the queue. Once in a process.
void begin_live_output(const Terminal& terminal);
bool is_output_live();

/// Text for this descriptor, which is standard output or standard error. Where the queue is full, the oldest text is
/// given up, and how many lines that were is said in its place. Throws Error::bad_file where standard output could not
/// be written before.
void put_live(int descriptor, std::string text);
/// Text for standard error that is made when it is written: of two that follow each other, with the same owner, only
/// the latter is.
void put_live_drawing(const void* owner, std::function<std::string()> draw);

/// Waits until everything is written, for at most two seconds. Throws Error::bad_file where standard output could not
/// be written; one that takes nothing is no error.
void flush_live_output();
/// As flush_live_output(), without an error, and the end of it.
void end_live_output();

}  // namespace tumble::cli
