// Signatures hold as long as what was signed is what it was.
#include <gtest/gtest.h>

#include "tumble/archive/history.hpp"
#include "tumble/archive/notes.hpp"
#include "tumble/archive/schema/opened.hpp"
#include "tumble/archive/signatures.hpp"
#include "tumble/archive/testing/suite_helpers.hpp"
#include "tumble/archive/transfer.hpp"
#include "tumble/formats/checksum.hpp"

namespace tumble::testing {

namespace {

const UnitName unit{"gyro", "0173"};

ArchiveAct by(const std::string& who, const std::string& why = "all values are within their limits") {
  return {who, "2026-04-01T08:00:00Z", why};
}

/// The first result of the unit, with a certificate on it.
std::pair<std::string, std::string> with_certificate(const ArchivePlace& place, Archive& archive) {
  put_in(archive, fleet(place), sample_act());
  const auto result = unit_record(archive, unit).results[0].sha256;
  const auto path = write_file(place, "certificate.html", "<html>certificate 7</html>");
  Deposit deposit;
  deposit.certificates.push_back({path, result, "2026-7", "simple", "A. Example", "2026-03-31"});
  put_in(archive, deposit, sample_act());
  return {result, sha256_of("<html>certificate 7</html>")};
}

void signatures_say_who_signed_what(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  const auto [result, certificate] = with_certificate(place, archive);
  sign(archive, result.substr(0, 12), "reviewed", by("Li Wei"));
  sign(archive, certificate, "approved", by("A. Example"));
  const auto signatures = signatures_of(archive, unit);
  ASSERT_EQ(signatures.size(), 2u);
  EXPECT_EQ(signatures[0].sha256, result);
  EXPECT_EQ(signatures[0].kind + " " + signatures[0].meaning + " " + signatures[0].who, "result reviewed Li Wei");
  EXPECT_EQ(signatures[1].sha256, certificate);
  EXPECT_EQ(signatures[1].kind + " " + signatures[1].meaning, "certificate approved");
  EXPECT_EQ(signatures[1].why, "all values are within their limits");
  EXPECT_EQ(signatures[1].when, "2026-04-01T08:00:00Z");
  for (const auto& one : signatures) EXPECT_EQ(one.problem, "");
  EXPECT_TRUE(signatures_of(archive, {"gyro", "0174"}).empty());
  expect_sound(archive);
}

void poor_signatures_are_refused(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  const auto [result, certificate] = with_certificate(place, archive);
  const auto input = Error::Kind::bad_input;
  EXPECT_TRUE(refuses(input,
                      std::vector<Asked>{{.values = {"aproved", "approved"}},
                                         {.pattern = "the name is missing"},
                                         {.pattern = "say why"},
                                         {.pattern = "no result or certificate"}},
                      [&] { sign(archive, "0123456789", "aproved", {}); }));
  EXPECT_TRUE(refuses(input, Asked{.values = {""}}, [&] { sign(archive, "", "approved", by("Li Wei")); }));
  EXPECT_TRUE(refuses(input, Asked{.part = "'; DROP"},
                      [&] { sign(archive, "'; DROP TABLE events", "approved", by("Li Wei")); }));
  sign(archive, result, "approved", by("Li Wei"));
  EXPECT_TRUE(refuses(input, Asked{.values = {"Li Wei", "approved"}, .pattern = "already"},
                      [&] { sign(archive, result, "approved", by("Li Wei", "again")); }));
  sign(archive, result, "reviewed", by("Li Wei"));
  sign(archive, result, "approved", by("A. Example"));
  withdraw_result(archive, result, by("Li Wei", "wrong power supply"));
  const Asked withdrawn{.values = {"wrong power supply"}, .pattern = "does not count any more"};
  EXPECT_TRUE(refuses(input, withdrawn, [&] { sign(archive, result, "reviewed", by("A. Example")); }));
  EXPECT_TRUE(refuses(input, withdrawn, [&, of = certificate] { sign(archive, of, "approved", by("A. Example")); }))
      << "its result does not count";
  for (const auto& one : signatures_of(archive, unit))
    EXPECT_NE(one.problem.find("wrong power supply"), std::string::npos);
  expect_sound(archive);
}

void a_changed_file_has_no_signature(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  const auto [result, certificate] = with_certificate(place, archive);
  sign(archive, result, "approved", by("Li Wei"));
  allow_changes(archive, "results");
  auto& database = schema::opened(archive).database;
  auto packed = std::get<database::Bytes>(database.ask("SELECT packed FROM results WHERE sha256 = ?", {result})[0][0]);
  packed.data[packed.data.size() / 2] ^= 1;
  database.run("UPDATE results SET packed = ? WHERE sha256 = ?", {packed, result});
  ASSERT_EQ(signatures_of(archive, unit).size(), 1u);
  EXPECT_NE(signatures_of(archive, unit)[0].problem, "");
  EXPECT_TRUE(refuses(Error::Kind::bad_file, Asked{}, [&] { sign(archive, result, "approved", by("A. Example")); }));
}

void signatures_travel_with_their_unit(const ArchivePlace& place) {
  Archive archive = new_archive(place);
  const auto [result, certificate] = with_certificate(place, archive);
  sign(archive, certificate, "approved", by("Li Wei"));
  export_unit(archive, unit, place.folder + "/one.db", sample_act());
  const Archive one(place.folder + "/one.db");
  const auto signatures = signatures_of(one, unit);
  ASSERT_EQ(signatures.size(), 1u);
  EXPECT_EQ(signatures[0].who, "Li Wei");
  EXPECT_EQ(signatures[0].problem, "");
}

}  // namespace

std::vector<ArchiveCase> cases_of_signatures() {
  return {{"SignaturesSayWhoSignedWhat", signatures_say_who_signed_what},
          {"PoorSignaturesAreRefused", poor_signatures_are_refused},
          {"AChangedFileHasNoSignature", a_changed_file_has_no_signature},
          {"SignaturesTravelWithTheirUnit", signatures_travel_with_their_unit}};
}

}  // namespace tumble::testing
