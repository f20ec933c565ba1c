#pragma once

#include <fmt/format.h>

#include <string>

#include "tumble/exchange/certificate.hpp"

namespace tumble::certificate {

/// The words of a certificate in one language.
struct Words {
  Language language;

  std::string operator()(const char* key) const { return text_of(language, "certificate", key); }
  /// A sentence with values at {0}, {1}, ...
  template <class... Values>
  std::string with(const char* key, const Values&... values) const {
    return fmt::format(fmt::runtime((*this)(key)), values...);
  }
  /// "2026-11-02", in Chinese "2026年11月2日".
  std::string date(const Date& day) const;
  /// A unit as HTML; in Chinese as GB 3100 and 3101 write it: (°)/(h·g).
  std::string unit(const Unit& unit) const;
  /// The name of a parameter with blanks in place of underscores, or in Chinese, as HTML.
  std::string name(std::string_view key, std::string_view method) const;
  /// A symbol as HTML, Greek letters for their names.
  std::string symbol(std::string_view text) const;
};

/// Text without control characters, for places that are no HTML.
std::string printable_text(std::string_view text);

/// Sections of the page; empty where there is nothing to say.
std::string conditions_table(const Certificate& certificate, const Words& words);
std::string equipment_table(const Certificate& certificate, const Words& words);
std::string results_table(const Certificate& certificate, const Words& words);
std::string conformity(const Certificate& certificate, const Words& words);
std::string annex(const Certificate& certificate, const Words& words);

}  // namespace tumble::certificate
