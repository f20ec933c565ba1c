#pragma once

#include <cstdint>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/core/estimate.hpp"
#include "tumble/core/progress.hpp"
#include "tumble/methods/noise_parts.hpp"

/// One record in many files, which many processes work through: each file is measured, the files are laid out one after
/// the other, each is reduced, and the parts are joined in their order. The method is allan_noise.
namespace tumble {

/// One file of the record, as it was measured.
struct RecordPiece {
  std::string file, instrument;
  std::string begun, ended;      ///< UTC; empty where the file does not say it
  std::int64_t clock_start = 0;  ///< [ns] since 1970 of the first sample; 0 where the file does not say it
  std::string findings;          ///< of its reader: JSON of a result that holds them
  std::uint64_t bytes = 0;       ///< of its samples
  std::vector<ChannelExtent> channels;

  template <class State>
  void pass(State& state) {
    state(file, instrument, begun, ended, clock_start, findings, bytes, channels);
  }
  /// For another process of the same version.
  std::string to_bytes() const;
  /// Throws Error::bad_file.
  static RecordPiece from_bytes(std::string_view bytes);
};

/// Throws Error::bad_data, bad_file as gather().
RecordPiece measure_piece(const Plan& plan, const std::string& file, const Progress& progress);

/// How the files follow each other.
struct RecordLayout {
  std::vector<std::vector<PlaceInRecord>> places;  ///< by file and channel
  Findings findings;                               ///< of gaps between files
};

/// By the dates of the files where all have one, else by their clocks; but where the clocks of all files begin at the
/// same time, to 1 % of the longest, the files follow each other without a gap. A step of up to 2e-4 of the file before
/// and 1 s by the dates, or up to 1.5 samples by the clocks, is no gap.
///
/// Throws    Error::bad_data with all that does not fit: other channels, another rate, files that overlap
RecordLayout lay_out(const std::vector<RecordPiece>& pieces);

/// Part of one file that the method needs; the SHA-256 of the file.
struct ReducedPiece {
  NoisePart part;
  std::string sha256;
};
/// Throws as measure_piece(); Error::bad_data where the file has other samples than it was measured with.
ReducedPiece reduce_piece(const Plan& plan, const std::string& file, const RecordPiece& piece,
                          const std::vector<PlaceInRecord>& places, const Progress& progress);

/// The result of the whole record. Given: the pieces, their SHA-256, and their parts joined.
Estimate identify_pieces(const Plan& plan, const std::vector<RecordPiece>& pieces,
                         const std::vector<std::string>& sha256, const NoisePart& joined);

}  // namespace tumble
