#include "tumble/recorder/recorder.hpp"

#include "tumble/recorder/live_store/live_view.hpp"
#include "tumble/recorder/live_store/writer.hpp"

namespace tumble {

struct Recorder::Inner {
  live_store::Writer writer;
  std::unique_ptr<live_store::LiveView> view = {};
};

using live_store::Front;

Recorder::Recorder(const std::string& folder, Disk& disk, const RecorderOptions& options)
    : inner_(new Inner{{folder, disk, options}}) {
  if (options.view) inner_->view = std::make_unique<live_store::LiveView>(folder);
}
Recorder::~Recorder() = default;

Recorder::Whole::Whole(Recorder& recorder) : recorder_(recorder) { recorder.inner_->writer.hold(); }
Recorder::Whole::~Whole() { recorder_.inner_->writer.release(); }

std::size_t Recorder::add_link(const StoreLink& link) {
  return inner_->writer.append([&](Front& front) { return front.add_link(link); });
}

std::size_t Recorder::add_stream(const StoreStream& stream) {
  const std::size_t number = inner_->writer.append([&](Front& front) { return front.add_stream(stream); });
  if (inner_->view) inner_->view->add_stream(number, stream);
  return number;
}

void Recorder::set(const std::string& name, const std::string& value) {
  inner_->writer.append([&](Front& front) {
    front.set(name, value);
    return std::uint64_t{0};
  });
  if (inner_->view) inner_->view->set(name, value);
}

std::uint64_t Recorder::raw(std::size_t link, StoreDirection direction, double time, std::string_view bytes) {
  return inner_->writer.append([&](Front& front) { return front.raw(link, direction, time, bytes); });
}

std::uint64_t Recorder::sample(std::size_t stream, const StoreSample& sample) {
  const std::uint64_t sequence = inner_->writer.append([&](Front& front) { return front.sample(stream, sample); });
  if (inner_->view && sequence > 0) inner_->view->sample(stream, sample);
  return sequence;
}

std::uint64_t Recorder::event(const StoreEvent& event) {
  return inner_->writer.append([&](Front& front) { return front.event(event); });
}

std::uint64_t Recorder::journal(double time, const RunRow& row) {
  if (inner_->view) inner_->view->journal(time, row);
  return inner_->writer.append([&](Front& front) { return front.journal(time, row); });
}

bool Recorder::flush(double within) { return inner_->writer.flush(within); }
Acknowledged Recorder::acknowledged() const { return inner_->writer.acknowledged(); }
std::optional<StoreFailure> Recorder::failure() const { return inner_->writer.failure(); }
StoreLoad Recorder::load() const { return inner_->writer.load(); }
bool Recorder::close(double time, const Sentence& ending) {
  const bool good = inner_->writer.close(time, ending);
  inner_->view.reset();
  return good;
}

}  // namespace tumble
