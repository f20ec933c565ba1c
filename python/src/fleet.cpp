#include <nanobind/stl/pair.h>
#include <nanobind/stl/string.h>
#include <nanobind/stl/vector.h>

#include <memory>

#include "bindings.hpp"
#include "tumble/math/state.hpp"
#include "tumble/math/threads.hpp"
#include "tumble/report/report.hpp"
#include "tumble/tasks/long_record.hpp"

namespace tumble::python {
namespace {

std::string_view view(const nb::bytes& bytes) { return {bytes.c_str(), bytes.size()}; }

nb::bytes bytes_of(const std::string& text) { return nb::bytes(text.data(), text.size()); }

/// Places of the channels of one file, as they travel to a worker.
std::string bytes_of_places(std::vector<PlaceInRecord> places) {
  StateWriter state;
  state(places);
  return state.take();
}

std::vector<PlaceInRecord> places_of(std::string_view bytes) {
  std::vector<PlaceInRecord> places;
  StateReader state(bytes);
  state(places);
  return places;
}

std::vector<RecordPiece> pieces_of(const std::vector<nb::bytes>& given) {
  std::vector<RecordPiece> pieces;
  for (const auto& one : given) pieces.push_back(RecordPiece::from_bytes(view(one)));
  return pieces;
}

nb::bytes measure(const Plan& plan, const std::string& file, const std::string& name) {
  std::string state;
  {
    Unlocked unlocked;
    RecordPiece piece = measure_piece(plan, file, {});
    piece.file = name;
    state = piece.to_bytes();
  }
  return bytes_of(state);
}

std::pair<nb::bytes, std::string> reduce(const Plan& plan, const std::string& file, const nb::bytes& piece,
                                         const nb::bytes& places) {
  const RecordPiece measured = RecordPiece::from_bytes(view(piece));
  const auto where = places_of(view(places));
  std::string state, sha256;
  {
    Unlocked unlocked;
    const ReducedPiece reduced = reduce_piece(plan, file, measured, where, {});
    state = reduced.part.bytes();
    sha256 = reduced.sha256;
  }
  return {bytes_of(state), sha256};
}

std::vector<nb::bytes> places_of_pieces(const std::vector<nb::bytes>& pieces) {
  std::vector<nb::bytes> places;
  for (auto& one : lay_out(pieces_of(pieces)).places) places.push_back(bytes_of(bytes_of_places(std::move(one))));
  return places;
}

/// Parts of a record, joined as they come in their order.
class JoinedParts {
 public:
  void append(const nb::bytes& bytes) {
    NoisePart next = NoisePart::from_bytes(view(bytes));
    Unlocked unlocked;
    if (joined_)
      joined_->append(next);
    else
      joined_ = std::make_unique<NoisePart>(std::move(next));
  }

  Estimate identify(const Plan& plan, const std::vector<nb::bytes>& given,
                    const std::vector<std::string>& sha256) const {
    const auto pieces = pieces_of(given);
    Unlocked unlocked;
    return identify_pieces(plan, pieces, sha256, *joined_);
  }

 private:
  std::unique_ptr<NoisePart> joined_;
};

/// The result of one unit of a fleet: its serial number, and the name of its recording in place of that of a copy.
Estimate of_unit(Estimate estimate, const std::string& serial, const std::string& sha256, const std::string& name) {
  estimate.instrument_serial = serial;
  for (auto& input : estimate.provenance.inputs)
    if (input.sha256 == sha256) input.file = name;
  for (auto& table : estimate.tables)
    if (table.name == "recordings" && table.rows.size() == 1) table.rows[0][0] = name;
  return estimate;
}

}  // namespace

void bind_fleet(nb::module_& module) {
  using namespace nb::literals;
  module.def("limit_threads", &limit_threads, "count"_a);
  module.def("measure_piece", &measure, "plan"_a, "file"_a, "name"_a);
  module.def("places_of_pieces", &places_of_pieces, "pieces"_a);
  module.def("reduce_piece", &reduce, "plan"_a, "file"_a, "piece"_a, "places"_a);
  nb::class_<JoinedParts>(module, "JoinedParts")
      .def(nb::init<>())
      .def("append", &JoinedParts::append, "part"_a)
      .def("identify", &JoinedParts::identify, "plan"_a, "pieces"_a, "sha256"_a);
  module.def("of_unit", &of_unit, "estimate"_a, "serial"_a, "sha256"_a, "name"_a);
}

}  // namespace tumble::python
