#include <algorithm>

#include "tumble/exchange/certificate/page.hpp"
#include "tumble/exchange/certificate/work.hpp"
#include "tumble/exchange/certificate/xml.hpp"
#include "tumble/version.hpp"

namespace tumble::certificate {
namespace {

constexpr const char* definitions[][3] = {
    {"basic", "basic", "https://digilab.ptb.de/dkd/refType/vocab/index.php?tema=2"},
    {"Tumble", "tumble", "urn:tumble:refType"}};

void write_software(Xml parent, const char* name) {
  const auto software = element(element(parent, name), "dcc:software");
  plain(software, "dcc:name", "Tumble");
  leaf(software, "dcc:release", "v" + std::string(version));  // the Schematron wants a letter in front
  leaf(software, "dcc:type", "application");
}

void write_location(Xml contact, const Contact& who) {
  const auto location = element(contact, "dcc:location");
  optional_leaf(location, "dcc:street", who.street);
  optional_leaf(location, "dcc:postCode", who.post_code);
  optional_leaf(location, "dcc:city", who.city);
  optional_leaf(location, "dcc:state", who.state);
  optional_leaf(location, "dcc:countryCode", who.country);
}

void write_contact(Xml contact, const Contact& who) {
  plain(contact, "dcc:name", who.name);
  optional_leaf(contact, "dcc:eMail", who.email);
  optional_leaf(contact, "dcc:phone", who.phone);
  optional_leaf(contact, "dcc:link", who.link);
  write_location(contact, who);
}

void write_core(Xml administrative, const CertificateDetails& details) {
  const auto core = element(administrative, "dcc:coreData");
  leaf(core, "dcc:countryCodeISO3166_1", details.laboratory.contact.country);
  for (const auto language : languages_of(details)) leaf(core, "dcc:usedLangCodeISO639_1", code_of(language));
  leaf(core, "dcc:mandatoryLangCodeISO639_1", code_of(details.language));
  leaf(core, "dcc:uniqueIdentifier", details.number);
  if (details.received) leaf(core, "dcc:receiptDate", iso_date(*details.received));
  leaf(core, "dcc:beginPerformanceDate", iso_date(*details.begun));
  leaf(core, "dcc:endPerformanceDate", iso_date(*details.ended));
  leaf(core, "dcc:performanceLocation", details.place);
  leaf(core, "dcc:issueDate", iso_date(*details.issued));
  if (details.replaces.empty()) return;
  const auto amended = element(core, "dcc:reportAmendedSubstituted");
  leaf(amended, "dcc:typeOfChange", "amended");
  leaf(amended, "dcc:replacedUniqueIdentifier", details.replaces);
}

void write_identification(Xml list, const char* issuer, const std::string& value, const char* kind) {
  if (value.empty()) return;
  const auto identification = element(list, "dcc:identification");
  mark(identification, "refType", kind);
  leaf(identification, "dcc:issuer", issuer);
  leaf(identification, "dcc:value", value);
}

void write_item(Xml administrative, const Certificate& certificate) {
  const auto& item = certificate.details.item;
  const auto node = element(element(administrative, "dcc:items"), "dcc:item");
  plain(node, "dcc:name", item.name.empty() ? item.model : item.name);
  if (!item.manufacturer.empty()) plain(element(node, "dcc:manufacturer"), "dcc:name", item.manufacturer);
  leaf(node, "dcc:model", item.model);
  const auto identifications = element(node, "dcc:identifications");
  write_identification(identifications, "manufacturer", item.serial, "basic_serialNumber");
  write_identification(identifications, "customer", item.customer_number, "basic_customerNumber");
}

void write_persons(Xml administrative, const CertificateDetails& details) {
  const auto list = element(administrative, "dcc:respPersons");
  for (const auto& person : details.persons) {
    const auto node = element(list, "dcc:respPerson");
    plain(element(node, "dcc:person"), "dcc:name", person.name);
    optional_leaf(node, "dcc:role", person.role);
    leaf(node, "dcc:mainSigner", person.signs ? "true" : "false");
  }
}

Xml statement(Xml list, const char* kind) {
  const auto node = element(list, "dcc:statement");
  mark(node, "refType", kind);
  return node;
}

void write_rule(Xml list, const Certificate& certificate) {
  const auto& details = certificate.details;
  if (certificate.statements.empty()) {
    said(statement(list, "tumble_noConformityStatement"), "dcc:declaration", details, "no_statement");
    return;
  }
  const auto node = statement(list, "basic_decisionRule");
  leaf(node, "dcc:norm", "ILAC-G8:09/2019");
  leaf(node, "dcc:norm", "JCGM 106:2012");
  optional_leaf(node, "dcc:reference", details.rule_agreed_with);
  const auto declaration = element(node, "dcc:declaration");
  for (const auto language : languages_of(details)) {
    leaf(declaration, "dcc:content", "(" + name(*details.rule) + ") " + rule_in_words(*details.rule, language));
    mark(declaration.last_child(), "lang", code_of(language));
  }
  if (certificate.joint)
    said(statement(list, "tumble_jointConformity"), "dcc:declaration", details, "joint", percent(*certificate.joint));
}

void write_statements(Xml administrative, const Certificate& certificate) {
  const auto& details = certificate.details;
  const auto list = element(administrative, "dcc:statements");
  if (const auto seed = certificate.estimate.provenance.seed)
    said(statement(list, "tumble_specimen"), "dcc:declaration", details, "specimen", std::to_string(*seed));
  write_rule(list, certificate);
  plain(statement(list, "basic_metrologicalTraceability"), "dcc:declaration", details.traceability);
  for (const auto& one : details.equipment)
    if (one.due && *one.due < *details.ended) {
      const auto node = statement(list, "tumble_equipmentOutOfDate");
      plain(node, "dcc:declaration", one.name + ": " + iso_date(*one.due) + ": " + one.accepted_out_of_date);
    }
  for (const auto& one : certificate.statements)
    if (one.undermined)
      said(statement(list, "tumble_noConformityStatement"), "dcc:declaration", details, "undermined", one.parameter);
  if (!details.replaces_reason.empty())
    plain(statement(list, "tumble_reasonOfAmendment"), "dcc:declaration", details.replaces_reason);
  for (const auto& remark : details.remarks) plain(statement(list, "basic_note"), "dcc:declaration", remark);
  said(statement(list, "basic_note"), "dcc:declaration", details, "only_item");
  said(statement(list, "basic_note"), "dcc:declaration", details, "whole_copy");
}

void write_equipment(Xml measurement, const CertificateDetails& details) {
  if (details.equipment.empty()) return;
  const auto list = element(measurement, "dcc:measuringEquipments");
  for (const auto& one : details.equipment) {
    const auto node = element(list, "dcc:measuringEquipment");
    mark(node, "refType", "basic_calibrationEquipment");
    plain(node, "dcc:name", one.name);
    if (one.due)
      said(node, "dcc:description", details, "equipment_due_sentence", iso_date(*one.due),
           one.traceable_to.empty() ? "-" : one.traceable_to);
    if (!one.certificate.empty() && !one.certificate_sha256.empty()) {
      const auto hash = element(node, "dcc:certificate");
      said(hash, "dcc:referral", details, "equipment_certificate");
      leaf(hash, "dcc:referralID", one.certificate);
      leaf(hash, "dcc:procedure", "sha256");
      leaf(hash, "dcc:value", one.certificate_sha256);
    }
    if (!one.manufacturer.empty()) plain(element(node, "dcc:manufacturer"), "dcc:name", one.manufacturer);
    optional_leaf(node, "dcc:model", one.model);
    if (one.serial.empty() && one.certificate.empty()) continue;
    const auto identifications = element(node, "dcc:identifications");
    write_identification(identifications, "manufacturer", one.serial, "basic_serialNumber");
    write_identification(identifications, "calibrationLaboratory", one.certificate, "basic_certificateIdentification");
  }
}

void write_conditions(Xml measurement, const CertificateDetails& details) {
  const auto list = element(measurement, "dcc:influenceConditions");
  for (const auto& condition : details.conditions) {
    const auto node = element(list, "dcc:influenceCondition");
    plain(node, "dcc:name", condition.name);
    quantity_k2(element(element(node, "dcc:data"), "dcc:quantity"), condition.value, condition.unit,
                condition.uncertainty);
  }
}

}  // namespace

void write_administrative_data(Xml root, const Certificate& certificate) {
  const auto& details = certificate.details;
  const auto administrative = element(root, "dcc:administrativeData");
  write_software(administrative, "dcc:dccSoftware");
  const auto types = element(administrative, "dcc:refTypeDefinitions");
  for (const auto& [title, space, link] : definitions) {
    const auto definition = element(types, "dcc:refTypeDefinition");
    plain(definition, "dcc:name", title);
    leaf(definition, "dcc:namespace", space);
    leaf(definition, "dcc:link", link);
  }
  write_core(administrative, details);
  write_item(administrative, certificate);
  const auto laboratory = element(administrative, "dcc:calibrationLaboratory");
  optional_leaf(laboratory, "dcc:calibrationLaboratoryCode", details.laboratory.code);
  write_contact(element(laboratory, "dcc:contact"), details.laboratory.contact);
  write_persons(administrative, details);
  write_contact(element(administrative, "dcc:customer"), details.customer);
  write_statements(administrative, certificate);
}

Xml write_measurement(Xml root, const Certificate& certificate) {
  const auto& details = certificate.details;
  const auto measurement = element(element(root, "dcc:measurementResults"), "dcc:measurementResult");
  plain(measurement, "dcc:name",
        certificate.estimate.title.empty() ? certificate.estimate.method : certificate.estimate.title);
  const auto method = element(element(measurement, "dcc:usedMethods"), "dcc:usedMethod");
  mark(method, "refType", "basic_calibrationMethod");
  plain(method, "dcc:name", certificate.estimate.method);
  optional_leaf(method, "dcc:norm", details.norm);
  write_software(measurement, "dcc:usedSoftware");
  write_equipment(measurement, details);
  write_conditions(measurement, details);
  return measurement;
}

}  // namespace tumble::certificate
