// Looks at a page after it has loaded and sends what is wrong with it to the frame around it.
(() => {
  const faults = [];
  const fault = text => { if (faults.length < 12) faults.push(text); };
  // Smallest letters, CSS pixels: in running text and in a plot.
  const TEXT_PX = 12, PLOT_PX = 11;
  // WCAG 2.1, success criterion 1.4.3.
  const CONTRAST = 4.5;
  addEventListener('error', event => fault('script error: ' + event.message), true);
  addEventListener('securitypolicyviolation', event => fault('asks for ' + event.blockedURI));
  const list = (query, from = document) => [...from.querySelectorAll(query)];
  const seen = element => element.getClientRects().length > 0;
  const named = element => element.tagName + (element.className?.baseVal ?? element.className ?? '').replace?.(/^(?=.)/, '.');
  const start = element => element.textContent.trim().slice(0, 30);

  // Red, green, blue (0 to 255) and opacity of a computed colour.
  const parts = colour => { const [r, g, b, a = 1] = colour.match(/[\d.]+/g).map(Number); return [r, g, b, a]; };
  const over = ([r, g, b, a], under) => [r, g, b].map((v, k) => a * v + (1 - a) * under[k]);
  const luminance = rgb => {
    const [r, g, b] = rgb.map(v => v / 255).map(v => v <= 0.04045 ? v / 12.92 : ((v + 0.055) / 1.055) ** 2.4);
    return 0.2126 * r + 0.7152 * g + 0.0722 * b;
  };
  const contrast = (one, other) => {
    const [light, dark] = [luminance(one), luminance(other)].sort((a, b) => b - a);
    return (light + 0.05) / (dark + 0.05);
  };
  const ground = element => {
    if (!element) return [255, 255, 255];
    const colour = parts(getComputedStyle(element).backgroundColor);
    return colour[3] === 1 ? colour.slice(0, 3) : over(colour, ground(element.parentElement));
  };
  const letters = element => {
    const style = getComputedStyle(element), plot = element.closest('svg');
    if (!plot) return { size: parseFloat(style.fontSize), least: TEXT_PX, colour: style.color };
    const scale = plot.getBoundingClientRect().width / plot.viewBox.baseVal.width;
    return { size: scale * parseFloat(style.fontSize), least: PLOT_PX, colour: style.fill };
  };
  const legible = () => {
    for (const element of list('body *')) {
      const own = [...element.childNodes].some(node => node.nodeType === 3 && node.data.trim());
      if (!own || !seen(element) || element.tagName === 'SCRIPT') continue;
      const { size, least, colour } = letters(element);
      if (size < least - 0.05) fault(`letters of ${size.toFixed(1)} px, at least ${least} wanted: ${start(element)}`);
      const under = ground(element), found = contrast(over(parts(colour), under), under);
      if (found < CONTRAST) fault(`contrast ${found.toFixed(2)}, at least ${CONTRAST} wanted: ${start(element)}`);
    }
  };

  const fits = () => {
    const page = document.documentElement;
    if (page.scrollWidth > innerWidth) fault('overflows by ' + (page.scrollWidth - innerWidth) + ' px');
    const wide = list('body *').filter(e => seen(e) && !e.closest('.scroll, pre') && e.getBoundingClientRect().right > page.clientWidth + 1);
    if (wide.length) fault('sticks out: ' + named(wide[0]) + ' ' + start(wide[0]));
    for (const details of list('details')) details.open = true;
    for (const table of list('.scroll').filter(seen)) {
      if (table.scrollWidth > table.clientWidth + 1) fault('a table is cut off: ' + start(table));
    }
  };

  const figures = () => {
    for (const figure of list('figure')) {
      const section = figure.closest('section'), name = section.querySelector('h2').textContent;
      const plots = list('svg', figure).filter(seen);
      if (plots.length !== 1) fault(`${name}: ${plots.length} plots to be seen`);
      for (const plot of plots) {
        if (!plot.getAttribute('aria-label') || plot.getAttribute('role') !== 'img') fault(name + ': no label');
        if (list('text', plot).length < 4) fault(name + ': axes without numbers or titles');
        const box = plot.getBoundingClientRect();
        for (const text of list('text', plot)) {
          const at = text.getBoundingClientRect();
          if (at.left < box.left - 1 || at.right > box.right + 1 || at.top < box.top - 1 || at.bottom > box.bottom + 1) fault(`${name}: cut off: ${start(text)}`);
        }
        if (!list('.mark[data-told]', plot).length) fault(name + ': no values for a pointer');
      }
      if (!figure.querySelector('figcaption')?.textContent.trim()) fault(name + ': no caption');
      if (!section.querySelector('details table tbody tr')) fault(name + ': no table');
    }
    for (const measure of list('.measures > div')) {
      if (!measure.querySelector('dt')?.textContent.trim() || !measure.querySelector('dd')?.textContent.trim()) fault('a number without its name');
    }
  };

  const hovers = () => {
    const mark = list('.mark').find(seen);
    if (!mark) return;
    const box = mark.getBoundingClientRect();
    const at = { clientX: box.left + box.width / 2, clientY: box.top + box.height / 2, bubbles: true };
    mark.dispatchEvent(new PointerEvent('pointermove', at));
    const tip = document.querySelector('.tip');
    if (!tip || tip.hidden || tip.textContent !== mark.dataset.told) fault('a pointer over a plot is told nothing');
    else {
      const around = tip.getBoundingClientRect();
      if (around.left < 0 || around.right > innerWidth + 1) fault('what a pointer is told is cut off');
    }
  };

  addEventListener('load', () => {
    for (const look of [fits, figures, legible, hovers]) {
      try { look(); } catch (error) { fault('the probe: ' + error.message); }
    }
    const asked = performance.getEntriesByType('resource').filter(entry => !entry.name.startsWith('data:'));
    if (asked.length) fault('asks for ' + asked[0].name);
    const dark = matchMedia('(prefers-color-scheme: dark)').matches;
    parent.postMessage({ page: location.href, width: innerWidth, dark, figures: list('figure').length, faults }, '*');
  });
})();
