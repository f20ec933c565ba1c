#pragma once

#include <string>
#include <vector>

#include "tumble/archive/history.hpp"

/// Signatures of people under results and certificates: events in the chain of the unit, which hold the SHA-256 of what
/// was signed. They prove as much as the chain does (docs/archive.md); who asks for the password is the front end.
namespace tumble {

/// Meanings that a signature may have: "reviewed", "approved".
const std::vector<std::string>& signature_meanings();

/// A result or certificate that may be signed.
struct SignedThing {
  std::string kind;  ///< "result", "certificate"; empty: the archive has neither
  std::string sha256;
  UnitName unit;
  std::string withdrawn;  ///< why it does not count any more; empty: it counts
};
/// The result or certificate of this SHA-256, or of the only one that begins so (six digits or more).
SignedThing find_signable(const Archive& archive, const std::string& digits);

/// Appends a signature.
///
/// Given     digits   of the result or certificate, as find_signable()
///           meaning  one of signature_meanings()
///           act      who signs, when, and why
/// Throws    Error::bad_input with all that is wrong: nothing of that name, a result that does not count any more, no
///           reason, the same person with the same meaning again; Error::bad_file where its bytes have changed
void sign(Archive& archive, const std::string& digits, const std::string& meaning, const ArchiveAct& act);

/// All signatures in the chain of a unit, in order; each is compared with the bytes that the archive has now.
std::vector<Signature> signatures_of(const Archive& archive, const UnitName& unit);

}  // namespace tumble
