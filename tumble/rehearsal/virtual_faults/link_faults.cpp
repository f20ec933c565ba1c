#include <algorithm>
#include <cmath>

#include "tumble/rehearsal/virtual_faults.hpp"

namespace tumble {
namespace {

bool in_force(const VirtualFault& fault, double time) {
  return time >= fault.at && (!fault.lasts || time < fault.at + *fault.lasts);
}

/// Drops and delays have no single message: without an end they last.
bool has_one_message(const VirtualFault& fault) {
  return !fault.lasts && fault.kind != FaultKind::drop_link && fault.kind != FaultKind::half_open &&
         fault.kind != FaultKind::delay;
}

}  // namespace

LinkFaults::LinkFaults(const std::vector<VirtualFault>& faults, std::string link, std::uint64_t seed)
    : link_(std::move(link)), random_(RandomStream(seed).split("link faults").split(link_)) {
  for (const auto& fault : faults)
    if (rule_of(fault.kind).place == FaultPlace::link && (fault.about.empty() || fault.about == link_))
      faults_.push_back({fault});
}

bool LinkFaults::is_up(double time) const {
  return std::ranges::none_of(faults_, [&](const Active& active) {
    return active.fault.kind == FaultKind::drop_link && in_force(active.fault, time);
  });
}

/// Whether the fault meets this message: the next one, or with `for` its share of all.
bool LinkFaults::hits(Active& active, double time) {
  if (active.spent || !in_force(active.fault, time)) return false;
  if (has_one_message(active.fault)) return active.spent = true;
  const bool all = active.fault.kind == FaultKind::delay || active.fault.by >= 1.0 ||
                   active.fault.kind == FaultKind::drop_link || active.fault.kind == FaultKind::half_open;
  return all || random_.uniform(drawn_++) < active.fault.by;
}

void LinkFaults::change(FaultKind kind, std::string& message) {
  if (message.empty()) return;
  const auto place = [&](std::size_t size) {
    return std::min(size - 1, static_cast<std::size_t>(random_.uniform(drawn_++) * static_cast<double>(size)));
  };
  switch (kind) {
    case FaultKind::wrong_reply:
      if (!last_.empty()) message = last_;
      break;
    case FaultKind::cut_line:
      message.resize(message.size() / 2);
      break;
    case FaultKind::garbage_byte:
      message.insert(message.begin() + static_cast<std::ptrdiff_t>(place(message.size())),
                     static_cast<char>(place(256)));
      break;
    case FaultKind::crc_error: {
      const std::size_t at = message.size() / 2 + place(message.size() - message.size() / 2);
      message[at] = static_cast<char>(message[at] ^ 1 << place(8));
      break;
    }
    default:
      break;
  }
}

std::vector<TimedBytes> LinkFaults::pass(double time, std::string_view message) {
  std::string bytes(message);
  double arrives = time;
  int copies = 1;
  bool later = false;
  for (Active& active : faults_) {
    if (!hits(active, time)) continue;
    switch (active.fault.kind) {
      case FaultKind::drop_link:
      case FaultKind::half_open:
      case FaultKind::lost_frames:
        copies = 0;
        break;
      case FaultKind::duplicated_frames:
        copies *= 2;
        break;
      case FaultKind::reordered_frames:
        later = true;
        break;
      case FaultKind::delay:
        arrives = std::max(arrives, time + active.fault.by);
        break;
      default:
        change(active.fault.kind, bytes);
    }
  }
  last_ = message;
  std::vector<TimedBytes> out;
  arrives = last_time_ = std::max(arrives, last_time_);  // nothing overtakes on a line
  if (later && copies > 0 && !waiting_) {
    waiting_ = std::move(bytes);
    return out;
  }
  for (int copy = 0; copy < copies; ++copy) out.push_back({arrives, bytes});
  if (waiting_ && is_up(time)) out.push_back({arrives, std::move(*waiting_)});
  waiting_.reset();
  return out;
}

}  // namespace tumble
