#include <algorithm>
#include <array>
#include <cmath>
#include <string_view>

#include "tumble/exchange/certificate/page.hpp"
#include "tumble/report/in_language.hpp"
#include "tumble/report/markup.hpp"
#include "tumble/report/names.hpp"
#include "tumble/report/rounding.hpp"
#include "tumble/report/typeset.hpp"

namespace tumble::certificate {
namespace {

/// The tables of a validation that a customer sees; the others say what cannot go wrong unnoticed.
constexpr std::array shown_tables{"coverage", "sound_tests", "unnoticed", "what_would_show_it"};

std::string cell_html(const Table::Cell& cell, const Unit& unit) {
  if (const auto* text = std::get_if<std::string>(&cell)) return "<td>" + escaped(*text) + "</td>";
  const double value = unit.from_si(std::get<double>(cell));
  return "<td class=\"n\">" + (std::isfinite(value) ? typeset_number(general(value, 3)) : "–") + "</td>";
}

/// The columns that have room beside each other on a sheet; the others are in the file of the validation.
bool is_shown(const Table::Column& column) {
  constexpr std::array<std::string_view, 4> elsewhere{"said", "covered", "sd_predicted", "sd_of_bias"};
  return std::ranges::find(elsewhere, column.name) == elsewhere.end();
}

std::string table_html(const Table& table, const Table& shown, const Words& words) {
  std::string text = "<p>" + escaped(shown.caption) + "</p>\n<table>\n<thead><tr>";
  for (std::size_t i = 0; i < table.columns.size(); ++i)
    if (is_shown(table.columns[i]))
      text += "<th scope=\"col\">" + escaped(readable_name(shown.columns[i].name)) +
              (table.columns[i].unit.text() == "1" ? "" : " [" + words.unit(table.columns[i].unit) + "]") + "</th>";
  text += "</tr></thead>\n<tbody>\n";
  for (const auto& row : shown.rows) {
    text += "<tr>";
    for (std::size_t i = 0; i < row.size(); ++i)
      if (is_shown(table.columns[i])) text += cell_html(row[i], table.columns[i].unit);
    text += "</tr>\n";
  }
  return text + "</tbody></table>\n";
}

}  // namespace

std::string annex(const Certificate& certificate, const Words& words) {
  if (!certificate.validation) return {};
  const Estimate& english = certificate.validation->estimate;
  const Estimate shown = in_language(words.language, english);
  std::string text = "<section class=\"annex\"><h2>" + words("annex") + "</h2>\n<p>" + words("annex_note") + "</p>\n";
  for (const char* name : shown_tables)
    for (std::size_t i = 0; i < english.tables.size(); ++i)
      if (english.tables[i].name == name) text += table_html(english.tables[i], shown.tables[i], words);
  return text + "<p>" +
         words.with("annex_file", escaped(certificate.validation->file), escaped(certificate.validation->sha256)) +
         "</p>\n</section>\n";
}

}  // namespace tumble::certificate
