// The archive: what is known of each unit and of all. The address says which view.
import "./archive.css";
import { get } from "../api";
import { query } from "../route";
import { t } from "../texts";
import { useEffect, useState } from "preact/hooks";
import { addressIn, enter, ROOM } from "./answer";
import { CertificatePage } from "./certificate";
import { ChartPage } from "./chart";
import { DuePage } from "./due";
import { KeptPage } from "./kept";
import { PutPage } from "./put";
import { UnitPage } from "./unit";
import { UnitsPage } from "./units";

const VIEWS = ["units", "due", "put", "certificate"] as const;

function View() {
  const seen = query.value, view = seen.get("view");
  if (view === "due") return <DuePage />;
  if (view === "put") return <PutPage />;
  if (view === "certificate") return <CertificatePage />;
  if (seen.has("kept")) return <KeptPage sha256={seen.get("kept")!} unit={seen.get("unit") ?? ""} />;
  if (seen.has("parameter")) return <ChartPage />;
  const unit = seen.get("unit");
  return unit === null ? <UnitsPage /> : <UnitPage unit={unit} />;
}

export function ArchiveRoom() {
  const [has, setHas] = useState<boolean | null>(null);
  useEffect(() => void get<{ archive: boolean }>("/api/workbench").then(({ body }) => setHas(body.archive)), []);
  const current = query.value.get("view") ?? "units";
  if (has === null) return <h1>{t("archive")}</h1>;
  if (!has && current !== "certificate")
    return (
      <section>
        <h1>{t("archive")}</h1>
        <p class="notice">{t("archive_none")} <code>tumble archive init --archive lab.db</code>, <code>tumble serve --archive lab.db</code></p>
        <p><a href={addressIn({ view: "certificate" })} onClick={(event) => enter(event, { view: "certificate" })}>{t("archive_view_certificate")}</a></p>
      </section>
    );
  return (
    <div class="archive">
      <nav class="views" aria-label={t("archive")}>
        {VIEWS.filter((view) => has || view === "certificate").map((view) => (
          <a key={view} href={view === "units" ? ROOM : addressIn({ view })} aria-current={view === current ? "page" : undefined}
            onClick={(event) => enter(event, view === "units" ? {} : { view })}>{t(`archive_view_${view}`)}</a>
        ))}
      </nav>
      <View />
    </div>
  );
}
