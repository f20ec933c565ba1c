#include "tumble/station/recorder.hpp"

#include "tumble/station/recorder/writer.hpp"

namespace tumble {

struct Recorder::Inner {
  recorder::Writer writer;
};

using recorder::Front;

Recorder::Recorder(const std::string& folder, Disk& disk, const RecorderOptions& options)
    : inner_(new Inner{{folder, disk, options}}) {}
Recorder::~Recorder() = default;

std::size_t Recorder::add_link(const StoreLink& link) {
  return inner_->writer.append([&](Front& front) { return front.add_link(link); });
}

std::size_t Recorder::add_stream(const StoreStream& stream) {
  return inner_->writer.append([&](Front& front) { return front.add_stream(stream); });
}

void Recorder::set(const std::string& name, const std::string& value) {
  inner_->writer.append([&](Front& front) {
    front.set(name, value);
    return std::uint64_t{0};
  });
}

std::uint64_t Recorder::raw(std::size_t link, StoreDirection direction, double time, std::string_view bytes) {
  return inner_->writer.append([&](Front& front) { return front.raw(link, direction, time, bytes); });
}

std::uint64_t Recorder::sample(std::size_t stream, const StoreSample& sample) {
  return inner_->writer.append([&](Front& front) { return front.sample(stream, sample); });
}

std::uint64_t Recorder::event(const StoreEvent& event) {
  return inner_->writer.append([&](Front& front) { return front.event(event); });
}

std::uint64_t Recorder::journal(const JournalRow& row) {
  return inner_->writer.append([&](Front& front) { return front.journal(row); });
}

bool Recorder::flush(double within) { return inner_->writer.flush(within); }
Acknowledged Recorder::acknowledged() const { return inner_->writer.acknowledged(); }
std::optional<StoreFailure> Recorder::failure() const { return inner_->writer.failure(); }
StoreLoad Recorder::load() const { return inner_->writer.load(); }
bool Recorder::close(double time, const std::string& ending) { return inner_->writer.close(time, ending); }

}  // namespace tumble
