#pragma once

#include <map>
#include <memory>
#include <string>
#include <vector>

#include "tumble/station/executive.hpp"
#include "tumble/station/recorder/marks_of_journal.hpp"
#include "tumble/station/recorder/visit.hpp"
#include "tumble/wire/frames.hpp"

namespace tumble::recorder {

/// Facts about a run that are not samples: marks, how it ended, and what its links lost.
class RunReader {
 public:
  explicit RunReader(const StoreContent& content);
  void look(const StoreItem& item);
  /// After the last item.
  void finish();
  std::vector<Mark> marks() const { return journal_.marks(); }
  /// Findings about the links of a slot, and about the run.
  Findings findings(const StoreContent& content, const std::string& slot) const;
  const std::string& started() const { return started_; }  ///< UTC; empty: nobody said

 private:
  struct LinkReader {
    std::unique_ptr<FrameCodec> codec;
    std::unique_ptr<FrameStream> stream;
    std::size_t losses = 0;
    double first_loss = 0.0;  ///< [s]
  };
  void note(const StoreEvent& event);
  void note_rule(const StoreEvent& event);
  Findings findings_of_rules() const;

  std::vector<LinkReader> links_;
  std::map<std::string, std::size_t> link_of_name_;
  JournalReader journal_;
  std::map<std::pair<int, std::size_t>, RunRow>
      rules_;  ///< ends of attempts with a stopping rule, by power-up and index
  std::vector<std::pair<std::string, std::string>> accepted_;  ///< who accepted something, and what
  std::string started_, stopped_;
  bool ended_ = false;
  double last_ = 0.0, stopped_at_ = 0.0;  ///< [s]
};

}  // namespace tumble::recorder
