const health = await (await fetch("/healthz")).json();
document.getElementById("version").textContent = `Penumbra ${health.version}`;
