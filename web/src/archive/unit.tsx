// One unit: results, certificates, signatures, runs, files, and every event of its chain.
import type { ComponentChildren } from "preact";
import { bytes, t } from "../texts";
import { addressIn, enter, moment, nameOf, short, UnitRecord, useAnswer } from "./answer";
import { SignatureList } from "./sign";

function Table({ title, heads, rows, testid }: { title: string; heads: string[]; rows: ComponentChildren[][]; testid: string }) {
  if (rows.length === 0) return null;
  return (
    <section class="block" aria-label={title}>
      <h2>{title}</h2>
      <div class="scroll" tabIndex={0} role="group" aria-label={title}>
        <table class="list" data-testid={testid}>
          <thead><tr>{heads.map((head) => <th scope="col" key={head}>{head}</th>)}</tr></thead>
          <tbody>{rows.map((row, i) => <tr key={i}>{row.map((cell, k) => <td key={k}>{cell}</td>)}</tr>)}</tbody>
        </table>
      </div>
    </section>
  );
}

export function Verdict({ verdict }: { verdict: string }) {
  if (verdict === "pass") return <span class="badge good">✓ {t("archive_verdict_pass")}</span>;
  if (verdict === "fail") return <span class="badge error">✖ {t("archive_verdict_fail")}</span>;
  return verdict === "undecided" ? <span class="badge warning">⚠ {t("archive_verdict_undecided")}</span> : null;
}

function Parameters({ record }: { record: UnitRecord }) {
  if (record.parameters.length === 0) return null;
  return (
    <p class="links">{t("archive_over_time")}{" "}
      {record.parameters.map((parameter) => {
        const seen = { unit: nameOf(record), parameter, kind: "drift" };
        return <a key={parameter} href={addressIn(seen)} onClick={(event) => enter(event, seen)}>{parameter}</a>;
      })}
    </p>
  );
}

/// A result that was replaced stays, struck through, with the reason.
function resultRows(record: UnitRecord): ComponentChildren[][] {
  return record.results.map((one) => {
    const seen = { kept: one.sha256, unit: nameOf(record) }, out = one.reason !== "";
    const link = <a href={addressIn(seen)} onClick={(event) => enter(event, seen)}>{short(one.sha256)}</a>;
    return [
      out ? <s>{moment(one.ended || one.archived)}</s> : moment(one.ended || one.archived),
      out ? <s>{one.method}</s> : one.method,
      <Verdict verdict={one.verdict} />,
      one.by,
      link,
      [one.simulated ? t("archive_simulated") : "", out ? `${t("archive_replaced", { by: short(one.replaced_by) || "–" })}: ${one.reason}` : ""]
        .filter((word) => word !== "").join("; "),
    ];
  });
}

function certificateRows(record: UnitRecord): ComponentChildren[][] {
  return record.certificates.map((one) => {
    const seen = { kept: one.sha256, unit: nameOf(record) };
    return [<a href={addressIn(seen)} onClick={(event) => enter(event, seen)}>{one.number}</a>, one.format, one.issued, one.issued_by, short(one.result)];
  });
}

export function UnitPage({ unit }: { unit: string }) {
  const { body: record, problems } = useAnswer<UnitRecord>(`/api/archive/unit?unit=${encodeURIComponent(unit)}`);
  if (!record)
    return (
      <section><h1>{unit}</h1>{problems.map((problem) => <p class="problem" role="alert" key={problem}>{problem}</p>)}</section>
    );
  return (
    <section>
      <h1>{nameOf(record)}</h1>
      <Parameters record={record} />
      <Table title={t("archive_results")} testid="results" heads={["archive_ended", "archive_method", "archive_verdict", "archive_by", "archive_sha256", "archive_note"].map((key) => t(key))} rows={resultRows(record)} />
      <Table title={t("archive_certificates")} testid="certificates" heads={["archive_number", "archive_format", "archive_issued", "archive_by", "archive_result"].map((key) => t(key))} rows={certificateRows(record)} />
      <SignatureList signatures={record.signatures} />
      <Table title={t("archive_runs")} testid="runs" heads={["archive_started", "archive_title", "archive_station", "archive_slot", "archive_operator", "archive_ending"].map((key) => t(key))}
        rows={record.runs.map((one) => [moment(one.started), one.title, one.station, one.slot, one.operator, one.ending])} />
      <Table title={t("archive_files")} testid="files" heads={["archive_role", "archive_name", "archive_size", "archive_sha256"].map((key) => t(key))}
        rows={record.files.map((one) => [one.role, one.name, bytes(one.bytes), short(one.sha256)])} />
      <Table title={t("archive_events")} testid="events" heads={["archive_event", "archive_time", "archive_by", "archive_what", "archive_which", "archive_detail", "archive_why"].map((key) => t(key))}
        rows={record.events.map((one) => [String(one.number), moment(one.time), one.by, one.what, short(one.which), one.detail, one.why])} />
    </section>
  );
}
