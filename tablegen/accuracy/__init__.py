"""Measure how far the draws of a table are from direct simulation, and judge it.

Direct simulation is the reference: `tablegen.simulation` follows each grain through its contacts
with the wall. The particles of a measurement are new, so the fit of the table has never seen them.

A table has two laws. The law of first impacts draws from all grains of the population, without
spin. The spin law draws for one grain, which the particle keeps from hit to hit. They are compared
in this order:

====================  =====================================  =================  ==================
compared              where                                  in                 limits
====================  =====================================  =================  ==================
law of first impacts  conditions between nodes               `conditions`       ``ks`` to ``auc``
spin law, no spin     other conditions, two nearly normal    `conditions`       ``spin_ks`` to
                                                                                ``spin_auc``
spin law, with spin   hits 2 to 60 of grains between walls   `chains`           ``spin_chain_ks``
                                                                                to
                                                                                ``spin_chain_flat``
====================  =====================================  =================  ==================

The steps of `validate`, and the file of each:

1. `conditions` chooses angles and speeds between the nodes.
2. `measure` simulates and draws equally many states at each of them.
3. `comparison` compares the two samples by the four distances of `metrics`, and describes both by
   `descriptive`. `chains` compares the states of a grain from hit to hit.
4. `judgement` finds the worst number of each limit, and says whether it holds.
5. `accuracy_text` writes the result.

`tablegen.tables.generate` ends with the same steps, and the table stores the distances. Names,
limits and decimal places of all metrics are in `tablegen.config.metric_table`.
"""
