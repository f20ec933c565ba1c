#pragma once

#include <pugixml.hpp>
#include <string>
#include <string_view>
#include <vector>

#include "tumble/exchange/certificate.hpp"

namespace tumble::certificate {

using Xml = pugi::xml_node;

/// Languages of a DCC: that of the certificate, and English, in which parameters are described.
std::vector<Language> languages_of(const CertificateDetails& details);

/// A new child element.
Xml element(Xml parent, const char* name);
/// Gives an element an attribute.
void mark(Xml node, const char* attribute, const std::string& value);
/// A new child with text; control characters and blanks at its ends are removed.
void leaf(Xml parent, const char* name, std::string_view text);
/// A new child if there is text to write.
void optional_leaf(Xml parent, const char* name, std::string_view text);
/// The shortest decimal that reads back as the same double [any unit]; "NaN".
std::string decimal(double value);
/// A new child with a text of people, in no language.
Xml plain(Xml parent, const char* name, std::string_view text);
/// A new child with an English text.
Xml english(Xml parent, const char* name, std::string_view text, const CertificateDetails& details);
/// A new child with a text of the table [certificate] in each language; {0} and {1} are replaced.
Xml said(Xml parent, const char* name, const CertificateDetails& details, const char* key,
         const std::string& first = "", const std::string& second = "");

/// si:real or, where D-SI has the unit of people, si:hybrid with SI first. [SI] value; `uncertainty` may be null.
void quantity_value(Xml quantity, double value, const Unit& unit, const Measured* uncertainty);
/// [SI] A quantity with a value and an expanded uncertainty with k = 2.
void quantity_k2(Xml quantity, double value, const Unit& unit, const std::optional<double>& expanded);

void write_administrative_data(Xml root, const Certificate& certificate);
/// How it was measured: method, software, equipment, conditions.
///
/// Returned  the element that takes the results.
Xml write_measurement(Xml root, const Certificate& certificate);
void write_results(Xml measurement, const Certificate& certificate);

}  // namespace tumble::certificate
