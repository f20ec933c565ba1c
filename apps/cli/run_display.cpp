#include "run_display.hpp"

#include <fmt/format.h>

#include "tumble/language/said.hpp"
#include "tumble/report/text_table.hpp"
#include "tumble/units/unit.hpp"

namespace tumble::cli {
namespace {

/// Demanded and actual of each axis.
std::string axes_text(const RunView& view, const Terminal& terminal) {
  using Align = TextColumn::Align;
  TextColumn names{"axis", "", {}, Align::left}, demands{"demanded", "", {}}, positions{"at", "", {}},
      rates{"rate", "", {}};
  for (const auto& axis : view.axes) {
    const AxisTexts texts = texts_of(axis);
    names.cells.push_back(axis.name);
    demands.cells.push_back(texts.demanded);
    positions.cells.push_back(texts.position);
    rates.cells.push_back(texts.rate);
  }
  return names.cells.empty() ? "" : table_said(terminal, {names, demands, positions, rates});
}

std::string channels_text(const RunView& view, const Terminal& terminal) {
  using Align = TextColumn::Align;
  TextColumn names{"channel", "", {}, Align::left}, units{"unit", "", {}, Align::left};
  TextColumn means{"mean", "", {}}, sds{"sd", "", {}}, allans{"Allan 1 s", "", {}};
  for (const auto& channel : view.channels) {
    names.cells.push_back(channel.slot.empty() ? channel.name : channel.slot + "." + channel.name);
    units.cells.push_back(channel.unit.text());
    means.cells.push_back(fmt::format("{:.6g}", channel.unit.from_si(channel.mean)));
    sds.cells.push_back(fmt::format("{:.3g}", channel.unit.difference_from_si(channel.sd)));
    allans.cells.push_back(fmt::format("{:.3g}", channel.unit.difference_from_si(channel.allan)));
  }
  return names.cells.empty() ? "" : table_said(terminal, {names, units, means, sds, allans});
}

/// What the method makes of everything so far: of each unit the first parameters, those without a value yet excluded.
std::string estimates_text(const RunView& view, const Terminal& terminal) {
  using Align = TextColumn::Align;
  constexpr std::size_t most = 12;
  TextColumn names{"estimate so far", "", {}, Align::left}, units{"unit", "", {}, Align::left};
  TextColumn values{"value", "", {}}, sds{"sd", "", {}};
  for (const auto& estimate : view.estimates) {
    if (names.cells.size() == most) break;
    names.cells.push_back(view.estimates.front().slot == view.estimates.back().slot
                              ? estimate.name
                              : estimate.slot + "." + estimate.name);
    units.cells.push_back(estimate.unit.text());
    values.cells.push_back(fmt::format("{:.6g}", estimate.unit.from_si(estimate.value)));
    sds.cells.push_back(fmt::format("{:.3g}", estimate.unit.difference_from_si(estimate.sd)));
  }
  return names.cells.empty() ? "" : "\n" + table_said(terminal, {names, units, values, sds});
}

}  // namespace

void RunDisplay::show(const RunView& view) {
  if (!terminal_.live) return;
  std::string text =
      in_language(terminal_.language,
                  say("{}  {}  segment {} of {} '{}', {} left; on disk up to {}\n{} frames, {} lost, {} damaged\n\n",
                      Name{hours_text(view.time)}, Name{std::string(name(view.phase))},
                      std::min(view.segment + 1, view.segments), view.segments, view.label, Name{hours_text(view.left)},
                      Name{hours_text(view.acknowledged)}, view.frames, view.lost, view.damaged));
  text += axes_text(view, terminal_) + "\n" + channels_text(view, terminal_);
  text += estimates_text(view, terminal_);
  if (view.prompt) text += "\n" + in_language(terminal_.language, view.prompt->text) + "\n";
  block_.show(
      text + "\n" +
      in_language(terminal_.language, Sentence("p pauses at the next segment, r resumes, Ctrl+C ends the run safely")) +
      "\n");
}

std::string note_line(const Note& note, double time, Language language) {
  if (is_everyday(note.kind, note.phase)) return "";
  const std::string kind =
      padded(in_language(language, Sentence(std::string(name(note.kind)).c_str())), 10, TextColumn::Align::left);
  return fmt::format("{:>9}  {}  {}\n", hours_text(time), kind, in_language(language, note.text));
}

void RunDisplay::tell(const Note& note, double time) {
  const std::string line = note_line(note, time, terminal_.language);
  if (line.empty() || terminal_.quiet) return;
  block_.clear();
  print(line);
}

void RunDisplay::ask(const Prompt& prompt) {
  block_.clear();
  std::string choices;
  for (const auto& choice : prompt.choices) choices += (choices.empty() ? "" : ", ") + choice;
  print_said(terminal_,
             say("\n{}\n  answer one of: {} (Enter: {})\n", prompt.text, Name{choices}, Name{prompt.standard}));
}

}  // namespace tumble::cli
