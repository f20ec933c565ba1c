// A result or certificate that the archive keeps: its signatures, a form to sign, and the document itself.
import { useState } from "preact/hooks";
import { t } from "../texts";
import { addressIn, enter, moment, short, UnitRecord, useAnswer } from "./answer";
import { SignatureList, SignForm } from "./sign";
import { Verdict } from "./unit";

interface Comparison {
  file: string;
  sha256: string;
  archived: string;
  same: boolean;
  signatures: { meaning: string; by: string; time: string; problem: string }[];
}

/// A signature is of bytes: whether a file of the folder has them.
function Compare({ sha256 }: { sha256: string }) {
  const { body: listed } = useAnswer<{ certificates: string[]; results: string[] }>("/api/archive/candidates");
  const [file, setFile] = useState("");
  const { body, problems } = useAnswer<Comparison>(file === "" ? null : `/api/archive/compare?${new URLSearchParams({ file, sha256 })}`);
  return (
    <section class="block">
      <h2>{t("archive_compare")}</h2>
      <label class="search">{t("archive_file")}
        <select value={file} onChange={(event) => setFile(event.currentTarget.value)}>
          <option value="">–</option>
          {[...(listed?.certificates ?? []), ...(listed?.results ?? [])].map((name) => <option key={name} value={name}>{name}</option>)}
        </select>
      </label>
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {body && (
        <p role="status" data-testid="compared">
          {body.same ? <span class="badge good">✓ {t("archive_same")}</span> : <span class="badge error">✖ {t("archive_differs")}</span>}{" "}
          <code>{short(body.sha256)}</code>
        </p>
      )}
    </section>
  );
}

export function KeptPage({ sha256, unit }: { sha256: string; unit: string }) {
  const { body: record, problems } = useAnswer<UnitRecord>(`/api/archive/unit?unit=${encodeURIComponent(unit)}`);
  const certificate = record?.certificates.find((one) => one.sha256 === sha256);
  const result = record?.results.find((one) => one.sha256 === sha256);
  const address = `/api/archive/kept?sha256=${sha256}`;
  return (
    <section>
      <p class="links"><a href={addressIn({ unit })} onClick={(event) => enter(event, { unit })}>← {unit}</a></p>
      <h1>{certificate ? `${t("archive_of_certificate")} ${certificate.number}` : `${t("archive_of_result")} ${result?.method ?? ""}`}</h1>
      <p class="hint">SHA-256 <code class="hash">{sha256}</code></p>
      {problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}
      {record && !certificate && !result && <p class="problem" role="alert">{t("archive_not_there")}</p>}
      {result && <p><Verdict verdict={result.verdict} /> {moment(result.ended || result.archived)}, {result.by} <a href={address} target="_blank" rel="noopener">JSON</a></p>}
      {record && <SignatureList signatures={record.signatures.filter((one) => one.sha256 === sha256)} />}
      {(certificate || result) && <SignForm sha256={sha256} />}
      {(certificate || result) && <Compare sha256={sha256} />}
      {certificate?.format === "html" && <iframe class="page" sandbox="" src={address} title={t("archive_of_certificate")} />}
      {certificate?.format === "dcc" && <p><a href={address} target="_blank" rel="noopener">XML</a></p>}
    </section>
  );
}
